// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace plslam {

/// Items by bucket, in one block of memory (counting sort). Items of one bucket keep their order, and neighbouring
/// buckets are adjacent.
template <class Item>
class Buckets {
 public:
  /// No buckets.
  Buckets() = default;

  /// `bucket_of(item)` is a number from 0 to `n_buckets` - 1; it is called twice for each item.
  template <class BucketOf>
  Buckets(const std::vector<Item>& items, size_t n_buckets, const BucketOf& bucket_of)
      : begin_(n_buckets + 1), items_(items.size()) {
    const auto place = [&](const Item& item) { return static_cast<size_t>(bucket_of(item)); };
    for (const Item& item : items) ++begin_[place(item) + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    std::vector<size_t> next(begin_.begin(), begin_.end() - 1);
    for (const Item& item : items) items_[next[place(item)]++] = item;
  }

  /// Number of buckets.
  size_t size() const { return begin_.empty() ? 0 : begin_.size() - 1; }

  std::span<Item> operator[](size_t bucket) {
    return {items_.data() + begin_[bucket], items_.data() + begin_[bucket + 1]};
  }

  /// Items of the buckets from `first` up to but not including `end`.
  std::span<const Item> Range(size_t first, size_t end) const {
    return {items_.data() + begin_[first], items_.data() + begin_[end]};
  }

 private:
  std::vector<size_t> begin_;
  std::vector<Item> items_;
};

/// Returns the indices 0 to `n` - 1 by bucket: `bucket_of(index)`.
template <class BucketOf>
Buckets<int> IndicesByBucket(size_t n, size_t n_buckets, const BucketOf& bucket_of) {
  std::vector<int> places(n);
  std::iota(places.begin(), places.end(), 0);
  return Buckets<int>(places, n_buckets, bucket_of);
}

}  // namespace plslam
