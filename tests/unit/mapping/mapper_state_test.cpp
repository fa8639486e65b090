// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/mapper_state.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/mapping/loop_world.h"

namespace plslam::mapping {
namespace {

using Bytes = std::vector<uint8_t>;
using test::FeatureWorld;
using test::Walk;
using test::WalkOptions;

constexpr double kRadius_m = 6.0;
constexpr size_t kRound = 75;
constexpr size_t kLoopAt = kRound + 6;
constexpr size_t kSteps = kRound + 15;

/// An input of the mapper between two updates: a keyframe, or a closure from loop_process.
struct Word {
  std::optional<Keyframe> keyframe;
  LoopClosure closure;
};

MapUpdate Tell(const Word& word, Mapper& mapper) {
  std::string reason;
  if (word.keyframe) {
    EXPECT_TRUE(test::MapOne(*word.keyframe, mapper, &reason)) << reason;
  } else {
    EXPECT_TRUE(mapper.Correct(word.closure, &reason)) << reason;
    mapper.Commit();
  }
  return mapper.TakeUpdate();
}

Bytes Say(const Word& word, Mapper& mapper) { return test::Encoded(Tell(word, mapper)); }

Mapper Restored(const Mapper& mapper) {
  return {FeatureWorld::Camera(), MappingOptions(), DecodeState(EncodeState(mapper.State()))};
}

/// A lockstep stream: a little more than once round a ring with drift, the loop and a global bundle adjustment, then
/// another session; and the updates of an undisturbed mapper.
struct Stream {
  Stream() {
    Walk walk = test::MakeWalk(world, path, {.noise_px = 1.0});
    for (size_t i = kRound / 2; i < walk.keyframes.size(); ++i) {
      for (TrackId& id : walk.keyframes[i].point_landmark_ids) id.value += 1'000'000;
      for (TrackId& id : walk.keyframes[i].line_landmark_ids) id.value += 1'000'000;
    }
    for (size_t i = 0; i < walk.keyframes.size(); ++i) {
      Tell({walk.keyframes[i], {}});
      if (i == kRound) Tell({std::nullopt, test::Drift(mapper.map())});
      if (i == kLoopAt) {
        const test::Revisit revisit = test::RevisitOf(mapper.map(), walk.T_w_c);
        Tell({std::nullopt, test::CloseByTruth(mapper.map(), revisit, walk.T_w_c)});
        Tell({std::nullopt, test::AdjustByTruth(mapper.map(), walk.T_w_c)});
      } else {
        Tell({});
      }
    }
    WalkOptions options;
    options.session = 8;
    options.seed = 2;
    const Walk second = test::MakeWalk(world, {path.begin() + 4, path.begin() + 20}, options);
    for (const Keyframe& keyframe : second.keyframes) {
      Tell({keyframe, {}});
      Tell({});
    }
  }
  void Tell(const Word& word) {
    words.push_back(word);
    updates.push_back(Say(word, mapper));
  }

  FeatureWorld world = test::MakeRing(kRadius_m, 400, 100, 3);
  std::vector<SE3> path = test::RingPath(kRadius_m, 0.5, kSteps);
  Mapper mapper{FeatureWorld::Camera(), MappingOptions()};
  std::vector<Word> words;
  std::vector<Bytes> updates;
};

const Stream& TheStream() {
  static const Stream stream;
  return stream;
}

TEST(MapperState, StreamHasALoopCullingAndTwoSessions) {
  const Map& map = TheStream().mapper.map();
  EXPECT_EQ(map.loops().size(), 1U);
  EXPECT_LT(map.keyframes().size(), kSteps + 16);
  EXPECT_EQ(TheStream().mapper.State().stored.sessions.size(), 2U);
}

TEST(MapperState, RestoredAfterEachInputGivesSameUpdates) {
  const Stream& stream = TheStream();
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  for (size_t i = 0; i < stream.words.size(); ++i) {
    mapper = Restored(mapper);
    ASSERT_EQ(Say(stream.words[i], mapper), stream.updates[i]) << "word " << i << " of " << stream.words.size();
  }
  EXPECT_EQ(EncodeState(mapper.State()), EncodeState(stream.mapper.State()));
}

TEST(MapperState, RestoredOnceGivesTheSameUpdates) {
  const Stream& stream = TheStream();
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  for (size_t at = 0; at < stream.words.size(); ++at) {
    if (at % 23 == 7) {
      Mapper restored = Restored(mapper);
      EXPECT_EQ(test::Encoded(restored.Whole()), test::Encoded(mapper.Whole()));
      for (size_t i = at; i < stream.words.size(); ++i) {
        ASSERT_EQ(Say(stream.words[i], restored), stream.updates[i])
            << "replaced before word " << at << ", word " << i;
      }
      EXPECT_EQ(EncodeState(restored.State()), EncodeState(stream.mapper.State()));
    }
    Say(stream.words[at], mapper);
  }
}

/// Returns how often a mapper without a part of the state differs in the next four updates.
int Differences(void (*lack)(MapperState&)) {
  const Stream& stream = TheStream();
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  int n = 0;
  for (size_t at = 0; at + 4 < stream.words.size(); ++at) {
    if (at % 5 == 0) {
      MapperState state = mapper.State();
      lack(state);
      Mapper lacking(FeatureWorld::Camera(), MappingOptions(), state);
      bool differs = false;
      for (size_t i = at; i < at + 4; ++i) differs = Say(stream.words[i], lacking) != stream.updates[i] || differs;
      n += differs ? 1 : 0;
    }
    Say(stream.words[at], mapper);
  }
  return n;
}

TEST(MapperState, StateBeyondTheSavedMapMatters) {
  EXPECT_EQ(Differences([](MapperState&) {}), 0);
  EXPECT_GT(Differences([](MapperState& state) { state.recent_landmarks = {}; }), 0);
  EXPECT_GT(Differences([](MapperState& state) { state.tracker = {}; }), 0);
}

TEST(MapperState, SameBytesAgain) {
  const Bytes bytes = EncodeState(TheStream().mapper.State());
  EXPECT_EQ(EncodeState(DecodeState(bytes)), bytes);
}

class StateFileTest : public testing::Test {
 protected:
  StateFileTest() { StateFile(path_).Write(TheStream().mapper.State()); }
  ~StateFileTest() override { std::filesystem::remove(path_); }
  std::string WhyNot() const {
    try {
      ReadStateFile(path_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return {};
  }
  Bytes Read() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void Write(const Bytes& bytes) const {
    std::ofstream file(path_, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

  const std::string path_ = (std::filesystem::temp_directory_path() /
                             (std::string("mapper_state_") + std::to_string(reinterpret_cast<uintptr_t>(this))))
                                .string();
};

TEST(MapperState, LentStateIsReturnedAfterAnException) {
  Mapper mapper = Restored(TheStream().mapper);
  const Bytes whole = EncodeState(mapper.State());
  Bytes lent;
  mapper.LendState([&](MapperState& state) { lent = EncodeState(state); });
  EXPECT_EQ(lent, whole);
  EXPECT_THROW(mapper.LendState([](MapperState&) { throw std::runtime_error("disk full"); }), std::runtime_error);
  EXPECT_EQ(EncodeState(mapper.State()), whole);
}

TEST(MapperState, FailedSaveChangesNothing) {
  Mapper mapper = Restored(TheStream().mapper);
  const Bytes whole = EncodeState(mapper.State());
  EXPECT_THROW(mapper.LendStored([](StoredMap&) { throw std::runtime_error("disk full"); }), std::runtime_error);
  EXPECT_EQ(EncodeState(mapper.State()), whole);
  mapper.LendStored([](StoredMap&) {});
  EXPECT_NE(EncodeState(mapper.State()), whole) << "landmarks that are saved are not culled";
}

TEST_F(StateFileTest, RoundTrip) {
  EXPECT_EQ(EncodeState(ReadStateFile(path_)), EncodeState(TheStream().mapper.State()));
}

TEST_F(StateFileTest, InvalidFilesAreRefusedByName) {
  const Bytes whole = Read();
  Bytes damaged = whole;
  damaged[damaged.size() / 2] ^= 1;
  for (const Bytes& bytes : {Bytes{}, Bytes(whole.begin(), whole.end() - 1), Bytes(whole.begin(), whole.begin() + 40),
                             damaged, EncodeMap(TheStream().mapper.State().stored)}) {
    Write(bytes);
    EXPECT_EQ(WhyNot().find(path_ + ": "), 0U) << WhyNot();
  }
}

// Content that was cut off before it was sealed.
TEST(MapperState, TruncatedBytesAreRefused) {
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  for (size_t i = 0; i < 3; ++i) Say(TheStream().words[2 * i], mapper);
  const Bytes whole = EncodeState(mapper.State());
  ASSERT_NO_THROW(DecodeState(whole));
  for (size_t n = 0; n < whole.size(); n += 1 + whole.size() / 500) {
    EXPECT_THROW(DecodeState(std::span(whole).first(n)), std::runtime_error) << n << " of " << whole.size();
  }
}

/// A file to which every state of a stream was written, and these states.
struct Grown {
  explicit Grown(const std::string& path) {
    StateFile file(path);
    Mapper mapper(FeatureWorld::Camera(), MappingOptions());
    for (const Word& word : TheStream().words) {
      file.Note(Tell(word, mapper));
      if (++n_words % 5 != 0) continue;
      file.Write(mapper.State());
      states.push_back(EncodeState(mapper.State()));
      lengths.push_back(std::filesystem::file_size(path));
    }
  }
  int n_words = 0;
  std::vector<Bytes> states;
  std::vector<uint64_t> lengths;  ///< of the file, after each
};

TEST_F(StateFileTest, RewrittenBeforeThreeTimesTheStateSize) {
  const Grown grown(path_);
  EXPECT_EQ(EncodeState(ReadStateFile(path_)), grown.states.back());
  int n_appended = 0;
  for (size_t i = 1; i < grown.lengths.size(); ++i) {
    EXPECT_LT(grown.lengths[i], 3 * grown.states[i].size()) << i;
    n_appended += grown.lengths[i] > grown.lengths[i - 1] ? 1 : 0;
  }
  EXPECT_GT(n_appended, static_cast<int>(grown.lengths.size()) / 2);
}

TEST_F(StateFileTest, TruncatedOrDamagedFileHasAnEarlierState) {
  const Grown grown(path_);
  const Bytes whole = Read();
  size_t n_older = 0;
  for (size_t n = 1; n < whole.size(); n += 1 + whole.size() / 50) {
    Bytes damaged = whole;
    damaged[n] ^= 1;
    for (const Bytes& bytes : {Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)), damaged}) {
      Write(bytes);
      try {
        const Bytes state = EncodeState(ReadStateFile(path_));
        const auto found = std::find(grown.states.begin(), grown.states.end(), state);
        ASSERT_NE(found, grown.states.end()) << "a state that never was, of " << n << " bytes";
        n_older += found + 1 < grown.states.end() ? 1 : 0;
      } catch (const std::runtime_error& error) {
        EXPECT_EQ(std::string(error.what()).find(path_ + ": "), 0U) << error.what();
      }
    }
  }
  EXPECT_GT(n_older, 3U);
}

/// A loop between the oldest and the newest keyframe of the map, which it does not move.
LoopClosure LoopOver(const Map& map) {
  const MapKeyframe& oldest = map.keyframes().begin()->second;
  const MapKeyframe& newest = map.keyframes().rbegin()->second;
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.edges.push_back(
      {oldest.id, newest.id, oldest.T_w_kf.Inverse() * newest.T_w_kf, 1e-4 * Matrix6d::Identity(), 30, 5});
  return closure;
}

TEST_F(StateFileTest, RecordsLoopsOfForgottenKeyframes) {
  MappingOptions options;
  options.max_keyframes = 12;
  Mapper mapper(FeatureWorld::Camera(), options);
  StateFile file(path_);
  std::set<KeyframeId> ends;
  for (size_t i = 0; i < 30; ++i) {
    file.Note(Tell(TheStream().words[2 * i], mapper));
    const Map& map = mapper.map();
    if (i == 11) file.Note(Tell({std::nullopt, LoopOver(map)}, mapper));
    for (const LoopEdge& loop : map.loops()) {
      EXPECT_NE(map.FindKeyframe(loop.old_keyframe_id), nullptr) << i;
      EXPECT_NE(map.FindKeyframe(loop.keyframe_id), nullptr) << i;
      ends.insert({loop.old_keyframe_id, loop.keyframe_id});
    }
    if (i % 2 == 0) continue;
    file.Write(mapper.State());
    ASSERT_EQ(EncodeState(ReadStateFile(path_)), EncodeState(mapper.State())) << i;
  }
  EXPECT_GT(ends.size(), 2U) << "it has moved";
}

TEST_F(StateFileTest, RecordsForgettingCamerasAndLocaliseOnly) {
  MappingOptions options;
  options.max_keyframes = 12;
  Mapper mapper(FeatureWorld::Camera(), options);
  StateFile file(path_);
  for (size_t i = 0; i < 40; ++i) {
    Word word = TheStream().words[2 * i];
    if (i % 3 == 0) word.keyframe->features.image = TakenImage{0, 0, 700 + static_cast<int>(i), 480, 300.0};
    file.Note(Tell(word, mapper));
    mapper.SetLocaliseOnly(i % 4 == 3);
    file.Note(mapper.TakeUpdate());
    mapper.SetLocaliseOnly(false);
    if (i % 4 != 3) continue;
    mapper.SetLocaliseOnly(i % 8 == 3);
    file.Write(mapper.State());
    ASSERT_EQ(EncodeState(ReadStateFile(path_)), EncodeState(mapper.State())) << i;
    mapper.SetLocaliseOnly(false);
  }
  EXPECT_EQ(mapper.map().keyframes().size(), 12U);
}

TEST_F(StateFileTest, WrittenWholeForAnotherMapper) {
  StateFile file(path_);
  Mapper first(FeatureWorld::Camera(), MappingOptions());
  file.Note(Tell(TheStream().words[0], first));
  file.Write(first.State());
  MapperState state;
  first.Precede(state);
  Mapper second(FeatureWorld::Camera(), MappingOptions(), std::move(state));
  file.Reset();
  file.Write(second.State());
  EXPECT_EQ(EncodeState(ReadStateFile(path_)), EncodeState(second.State()));
}

TEST_F(StateFileTest, WrittenWholeAfterAFailedWrite) {
  const std::string folder = path_ + " folder";
  StateFile file(folder + "/state");
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  for (size_t i = 0; i < 3; ++i) {
    file.Note(Tell(TheStream().words[2 * i], mapper));
    EXPECT_THROW(file.Write(mapper.State()), std::runtime_error);
  }
  std::filesystem::create_directory(folder);
  file.Write(mapper.State());
  EXPECT_EQ(EncodeState(ReadStateFile(folder + "/state")), EncodeState(mapper.State()));
  std::filesystem::remove_all(folder);
}

TEST_F(StateFileTest, WrittenWholeAfterAForeignChange) {
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  StateFile file(path_);
  for (size_t i = 0; i < 3; ++i) {
    file.Note(Tell(TheStream().words[2 * i], mapper));
    file.Write(mapper.State());
    EXPECT_EQ(EncodeState(ReadStateFile(path_)), EncodeState(mapper.State())) << i;
    if (i == 0) Write({1, 2, 3});
    if (i == 1) std::filesystem::remove(path_);
  }
}

}  // namespace
}  // namespace plslam::mapping
