#pragma once

#include <thread>

namespace plslam {

/// Asks the kernel for short turns: a thread that wakes up then need not wait until another one, on the core that it wakes
/// on, has had its turn of some milliseconds. Its share of the processor stays what it was. Threads that are started
/// afterwards inherit it. From Linux 6.12 on; without effect before, or where threads are not scheduled as usual.
void AskForShortTurns();

/// `thread` will run on any of the caller's cores but the one that the caller is on. Where there is no other, or the system
/// refuses, the scheduler decides as ever. Returns the caller's core, -1 where it is unknown.
int KeepOffThisCore(std::thread& thread);

}  // namespace plslam
