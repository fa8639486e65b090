// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/bus/bus.h"

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

  /// Bytes that fit into an empty page.
  int64_t room() const { return room_; }

  /// Returns a page with room for `bytes` more. Throws std::invalid_argument if no page is large enough.
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

/// Outcome of adding a page. kComplete: `PageAssembler::Take` returns the value. kPassedOver: the page continues a
/// value whose first or middle pages are missing. kNonsense: an invalid page (values, counts). Both drop the pages
/// received so far.
enum class PageOutcome { kTaken, kComplete, kPassedOver, kNonsense };

/// Rules by which pages form a value.
template <class Page, class Value>
struct PageRules {
  /// Returns the head of a page without content; nullopt if it is invalid.
  std::optional<Value> (*head)(const Page& page);
  /// Returns whether the page belongs to the same value, by its head.
  bool (*same_head)(const Page& page, const Value& value);
  /// Adds the content; false if it is invalid.
  bool (*append)(const Page& page, Value& value);
  int32_t max_pages = 4096;
  /// Incomplete values at a time; beyond, all are dropped.
  size_t max_publishers = 64;
};

/// Reassembles pages (messages with `page` and `n_pages`), which arrive in order for each publisher.
template <class Page, class Value>
class PageAssembler {
 public:
  explicit PageAssembler(const PageRules<Page, Value>& rules) : rules_(rules) {}

  PageOutcome Add(const Page& page) {
    const int64_t source = page.header.source;
    auto head = rules_.head(page);
    const bool counts_ok =
        page.n_pages >= 1 && page.n_pages <= rules_.max_pages && page.page >= 0 && page.page < page.n_pages;
    if (!head || !counts_ok) {
      partials_.erase(source);
      return PageOutcome::kNonsense;
    }
    if (page.page == 0) {  // a page 0 in the middle of another value: that one has lost pages for good
      if (partials_.size() >= rules_.max_publishers && !partials_.contains(source)) partials_.clear();
      partials_[source] = {std::move(*head), 0, page.n_pages};
    }
    const auto found = partials_.find(source);
    if (found == partials_.end()) return PageOutcome::kPassedOver;
    return Extend(page, found);
  }

  Value Take() { return std::move(*std::exchange(complete_, std::nullopt)); }

 private:
  struct Partial {
    Value value;
    int32_t next_page = 0;
    int32_t n_pages = 0;
  };
  using Partials = std::map<int64_t, Partial>;  // by publisher

  PageOutcome Extend(const Page& page, typename Partials::iterator found) {
    Partial& partial = found->second;
    const bool expected =
        page.page == partial.next_page && page.n_pages == partial.n_pages && rules_.same_head(page, partial.value);
    if (!expected || !rules_.append(page, partial.value)) {
      partials_.erase(found);
      return expected ? PageOutcome::kNonsense : PageOutcome::kPassedOver;
    }
    if (++partial.next_page < partial.n_pages) return PageOutcome::kTaken;
    complete_ = std::move(partial.value);
    partials_.erase(found);
    return PageOutcome::kComplete;
  }

  PageRules<Page, Value> rules_;
  Partials partials_;
  std::optional<Value> complete_;
};

/// Hands every value that arrives in pages on `channel` to `handler`, on the thread of `Bus::Run`, until the returned
/// object is destroyed. Invalid pages, and pages that continue an unknown value, are counted in
/// `BusCounters::rejected`.
template <class Page, class Assembler, class Value>
std::shared_ptr<void> SubscribePaged(Bus& bus, const Channel& channel, std::function<void(const Value&)> handler) {
  struct State {
    Assembler assembler;
    std::function<void(const Value&)> handler;
  };
  const auto state = std::make_shared<State>();
  state->handler = std::move(handler);
  bus.Subscribe<Page>(channel, [&bus, weak = std::weak_ptr<State>(state)](const Page& page) {
    const auto still = weak.lock();
    if (still == nullptr) return;
    const PageOutcome outcome = still->assembler.Add(page);
    if (outcome == PageOutcome::kNonsense || outcome == PageOutcome::kPassedOver) bus.CountRejected();
    if (outcome == PageOutcome::kComplete) still->handler(still->assembler.Take());
  });
  return state;
}

}  // namespace plslam::bus
