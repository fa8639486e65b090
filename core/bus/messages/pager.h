#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plslam::bus {

/// Fills pages (messages with `page` and `n_pages`) one after another; every page starts as a copy of a head.
template <class Page>
class Pager {
 public:
  /// `first` is the head of page 0. `what` is named where the head of a page leaves no room.
  Pager(Page first, Page others, int64_t page_bytes, std::string what)
      : others_(std::move(others)),
        room_(page_bytes - others_.getEncodedSize()),
        left_(page_bytes - first.getEncodedSize()),
        what_(std::move(what)),
        pages_({std::move(first)}) {}

  /// What fits into an empty page.
  int64_t room() const { return room_; }

  /// A page with room for `bytes` more. Throws std::invalid_argument where no page has.
  Page& PageFor(int64_t bytes) {
    if (bytes > room_) throw std::invalid_argument("bus.max_message_bytes leaves no room for " + what_);
    if (bytes > left_) {
      pages_.push_back(others_);
      left_ = room_;
    }
    left_ -= bytes;
    return pages_.back();
  }

  std::vector<Page> Finish() {
    for (size_t i = 0; i < pages_.size(); ++i) {
      pages_[i].page = static_cast<int32_t>(i);
      pages_[i].n_pages = static_cast<int32_t>(pages_.size());
    }
    return std::move(pages_);
  }

 private:
  Page others_;
  int64_t room_;
  int64_t left_;
  std::string what_;
  std::vector<Page> pages_;
};

}  // namespace plslam::bus
