#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

namespace plslam::bus {

/// What became of a page. kComplete: `PageAssembler::Take` has the whole. kPassedOver: it goes on with something whose
/// beginning or middle never came. kNonsense: a page that cannot be (values, counts). What had come is dropped with
/// either.
enum class PageOutcome { kTaken, kComplete, kPassedOver, kNonsense };

/// How pages make a value.
template <class Page, class Value>
struct PageRules {
  /// What the head of a page says, without content; nullopt where it cannot be.
  std::optional<Value> (*head)(const Page& page);
  /// The page is of the same value, by its head.
  bool (*same_head)(const Page& page, const Value& value);
  /// Adds the content; false where it cannot be.
  bool (*append)(const Page& page, Value& value);
  int32_t max_pages = 4096;
  /// Values under way at a time; beyond, all are dropped.
  size_t max_publishers = 64;
};

/// Puts pages (messages with `page` and `n_pages`) together again; they come in order for each publisher.
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

}  // namespace plslam::bus
