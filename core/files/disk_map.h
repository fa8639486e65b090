// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "core/files/nameless_file.h"

namespace plslam {

/// A map from numbers (>= 0) to values of which only the newest are in memory, the others in a file without a name.
/// Numbers should be dense: 256 successive ones are one part of the file. If the file cannot be written, everything
/// stays in memory, and `failure` says why.
///
/// `Stored` is the form in the file: trivially copyable, constructed from a Value, with `Value Unpack() const`.
template <class Value, class Stored>
class DiskMap {
  static_assert(std::is_trivially_copyable_v<Stored>);
  static constexpr int64_t kBlock = 256;
  static constexpr size_t kInMemory = 4;

  struct Block {
    std::bitset<kBlock> has;
    std::array<Stored, kBlock> values;
  };
  /// A block in memory or, if there is none, in the file at that position.
  struct Place {
    std::shared_ptr<Block> block;
    int64_t slot = -1;
  };
  using Blocks = std::map<int64_t, Place>;

 public:
  /// Without a folder everything stays in memory.
  explicit DiskMap(const std::string& folder = "") : has_file_(!folder.empty()), file_(folder) {}
  DiskMap(DiskMap&&) noexcept = default;
  DiskMap& operator=(DiskMap&&) noexcept = default;

  void Set(int64_t key, const Value& value) {
    Block& block = Writable(key / kBlock);
    const auto i = static_cast<size_t>(key % kBlock);
    if (!block.has[i]) ++size_;
    block.has.set(i);
    block.values[i] = Stored(value);
  }

  std::optional<Value> Find(int64_t key) const {
    if (key < 0) return std::nullopt;
    if (found_ == nullptr || found_number_ != key / kBlock) {
      const auto place = blocks_.find(key / kBlock);
      if (place == blocks_.end()) return std::nullopt;
      found_ = Loaded(place->second);
      found_number_ = key / kBlock;
    }
    const auto i = static_cast<size_t>(key % kBlock);
    return found_->has[i] ? std::optional<Value>(found_->values[i].Unpack()) : std::nullopt;
  }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  /// One sentence if values that should be in the file are in memory.
  const std::string& failure() const { return file_.failure(); }

  /// Visits (number, value) pairs, by value, in either direction. Invalid after `Set`.
  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = std::pair<int64_t, Value>;
    using difference_type = std::ptrdiff_t;
    using pointer = const value_type*;
    using reference = value_type;

    value_type operator*() const {
      return {at_->first * kBlock + i_, block_->values[static_cast<size_t>(i_)].Unpack()};
    }
    Iterator& operator++() {
      for (++i_;; ++i_) {
        if (i_ == kBlock) {
          i_ = 0;
          ++at_;
          Load();
        }
        if (block_ == nullptr || block_->has[static_cast<size_t>(i_)]) return *this;
      }
    }
    Iterator& operator--() {
      for (;;) {
        if (block_ == nullptr || i_ == 0) {
          i_ = kBlock;
          --at_;
          Load();
        }
        if (block_->has[static_cast<size_t>(--i_)]) return *this;
      }
    }
    bool operator==(const Iterator& other) const { return at_ == other.at_ && i_ == other.i_; }

   private:
    friend class DiskMap;
    Iterator(const DiskMap* map, typename Blocks::const_iterator at) : map_(map), at_(at) { Load(); }
    void Load() { block_ = at_ == map_->blocks_.end() ? nullptr : map_->Loaded(at_->second); }

    const DiskMap* map_;
    typename Blocks::const_iterator at_;
    std::shared_ptr<const Block> block_;
    int64_t i_ = 0;
  };

  Iterator begin() const {
    Iterator first(this, blocks_.begin());
    if (first.block_ != nullptr && !first.block_->has[0]) ++first;
    return first;
  }
  Iterator end() const { return Iterator(this, blocks_.end()); }
  /// The values with the lowest and the highest number; the map must not be empty.
  std::pair<int64_t, Value> First() const { return *begin(); }
  std::pair<int64_t, Value> Last() const { return *--end(); }

 private:
  std::shared_ptr<const Block> Loaded(const Place& place) const {
    return place.block != nullptr ? place.block : FromFile(place.slot);
  }

  std::shared_ptr<Block> FromFile(int64_t slot) const {
    auto block = std::make_shared<Block>();
    file_.Read(slot * static_cast<int64_t>(sizeof(Block)), block.get(), sizeof(Block));
    return block;
  }

  Block& Writable(int64_t number) {
    Place& place = blocks_[number];
    if (place.block != nullptr) return *place.block;
    MoveOldestToFile();
    found_.reset();
    place.block = place.slot < 0 ? std::make_shared<Block>() : FromFile(place.slot);
    in_memory_.emplace(number, &place);
    return *place.block;
  }

  void MoveOldestToFile() {
    if (!has_file_ || !failure().empty() || in_memory_.size() < kInMemory) return;
    Place& place = *in_memory_.begin()->second;
    const int64_t slot = place.slot < 0 ? n_slots_ : place.slot;
    if (!file_.Write(slot * static_cast<int64_t>(sizeof(Block)), place.block.get(), sizeof(Block))) return;
    if (place.slot < 0) place.slot = n_slots_++;
    place.block.reset();
    in_memory_.erase(in_memory_.begin());
  }

  bool has_file_;
  NamelessFile file_;
  Blocks blocks_;
  std::map<int64_t, Place*> in_memory_;
  int64_t n_slots_ = 0;
  size_t size_ = 0;
  /// The block of the last `Find`: the next one is often in it.
  mutable std::shared_ptr<const Block> found_;
  mutable int64_t found_number_ = -1;
};

}  // namespace plslam
