// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plslam {

/// An ordered map from dense, ascending ids to values. As std::map, but lookup usually takes one step, and increment
/// needs no walk through a tree, which in large maps waits for memory at each level. Ids far apart cost a page each
/// (half a kilobyte), so that forged ids cannot make it allocate much.
///
/// Values keep their address until they are erased; iterators are valid until the next insertion or erasure.
template <class Key, class Value>
class IdMap {
 public:
  using key_type = Key;
  using mapped_type = Value;
  using value_type = std::pair<const Key, Value>;

 private:
  static constexpr int kPageBits = 6;
  static constexpr int kPageSize = 1 << kPageBits;

  struct Page {
    uint64_t used = 0;  ///< bit i: slot i has a value
    std::array<std::unique_ptr<value_type>, kPageSize> slots;
  };
  struct Entry {
    int64_t number = 0;  ///< page number: id >> kPageBits
    std::unique_ptr<Page> page;
  };

 public:
  class const_iterator {
   public:
    using iterator_category = std::bidirectional_iterator_tag;
    using value_type = IdMap::value_type;
    using difference_type = std::ptrdiff_t;
    using pointer = const value_type*;
    using reference = const value_type&;

    const_iterator() = default;
    reference operator*() const { return *(*pages_)[place_].page->slots[slot_]; }
    pointer operator->() const { return &**this; }
    bool operator==(const const_iterator& other) const { return place_ == other.place_ && slot_ == other.slot_; }

    const_iterator& operator++() {
      const uint64_t used = (*pages_)[place_].page->used;
      const uint64_t rest = slot_ + 1 < kPageSize ? used >> (slot_ + 1) << (slot_ + 1) : 0;
      if (rest != 0) {
        slot_ = std::countr_zero(rest);
      } else {
        ++place_;
        slot_ = place_ < pages_->size() ? std::countr_zero((*pages_)[place_].page->used) : 0;
      }
      return *this;
    }
    const_iterator& operator--() {
      const uint64_t before = slot_ > 0 ? (*pages_)[place_].page->used & ((uint64_t{1} << slot_) - 1) : 0;
      const uint64_t used = before != 0 ? before : (*pages_)[--place_].page->used;
      slot_ = kPageSize - 1 - std::countl_zero(used);
      return *this;
    }
    const_iterator operator++(int) { return std::exchange(*this, std::next(*this)); }
    const_iterator operator--(int) { return std::exchange(*this, std::prev(*this)); }

   private:
    friend class IdMap;
    const_iterator(const std::vector<Entry>& pages, size_t place, int slot)
        : pages_(&pages), place_(place), slot_(slot) {}

    const std::vector<Entry>* pages_ = nullptr;
    size_t place_ = 0;
    int slot_ = 0;
  };
  using iterator = const_iterator;
  using const_reverse_iterator = std::reverse_iterator<const_iterator>;

  IdMap() = default;
  IdMap(const IdMap& other) : size_(other.size_) {
    pages_.reserve(other.pages_.size());
    for (const Entry& entry : other.pages_) pages_.push_back({entry.number, Copy(*entry.page)});
  }
  IdMap(IdMap&& other) noexcept : pages_(std::move(other.pages_)), size_(std::exchange(other.size_, 0)) {
    other.pages_.clear();
  }
  IdMap& operator=(IdMap other) noexcept {
    pages_.swap(other.pages_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~IdMap() = default;

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const_iterator begin() const {
    return {pages_, 0, pages_.empty() ? 0 : std::countr_zero(pages_.front().page->used)};
  }
  const_iterator end() const { return {pages_, pages_.size(), 0}; }
  const_reverse_iterator rbegin() const { return const_reverse_iterator(end()); }
  const_reverse_iterator rend() const { return const_reverse_iterator(begin()); }

  /// Returns nullptr if there is none.
  const Value* Find(Key id) const {
    const int64_t number = PageOf(id);
    const size_t place = PageIndex(number);
    if (!HasPage(place, number)) return nullptr;
    const value_type* value = pages_[place].page->slots[SlotOf(id)].get();
    return value ? &value->second : nullptr;
  }
  Value* Find(Key id) { return const_cast<Value*>(std::as_const(*this).Find(id)); }
  bool contains(Key id) const { return Find(id) != nullptr; }

  /// Throws std::out_of_range if there is none.
  const Value& at(Key id) const {
    const Value* value = Find(id);
    if (value == nullptr) throw std::out_of_range("no value has the id " + std::to_string(id.value));
    return *value;
  }
  Value& at(Key id) { return const_cast<Value&>(std::as_const(*this).at(id)); }

  /// Returns the value of the id, constructed from `arguments` if there was none; and whether there was none.
  template <class... Arguments>
  std::pair<Value*, bool> try_emplace(Key id, Arguments&&... arguments) {
    if (Value* value = Find(id)) return {value, false};
    auto value = std::make_unique<value_type>(std::piecewise_construct, std::forward_as_tuple(id),
                                              std::forward_as_tuple(std::forward<Arguments>(arguments)...));
    Page& page = PageFor(PageOf(id));
    page.used |= uint64_t{1} << SlotOf(id);
    ++size_;
    page.slots[SlotOf(id)] = std::move(value);
    return {&page.slots[SlotOf(id)]->second, true};
  }
  Value& operator[](Key id) { return *try_emplace(id).first; }

  /// Returns the number of erased values: one or none.
  size_t erase(Key id) {
    const int64_t number = PageOf(id);
    const size_t place = PageIndex(number);
    if (!HasPage(place, number)) return 0;
    Page& page = *pages_[place].page;
    if (page.slots[SlotOf(id)] == nullptr) return 0;
    page.slots[SlotOf(id)].reset();
    page.used &= ~(uint64_t{1} << SlotOf(id));
    if (page.used == 0) pages_.erase(pages_.begin() + static_cast<std::ptrdiff_t>(place));
    --size_;
    return 1;
  }

 private:
  static int64_t PageOf(Key id) { return id.value >> kPageBits; }
  static size_t SlotOf(Key id) { return static_cast<size_t>(id.value & (kPageSize - 1)); }

  static std::unique_ptr<Page> Copy(const Page& page) {
    auto copy = std::make_unique<Page>();
    copy->used = page.used;
    for (size_t i = 0; i < page.slots.size(); ++i) {
      if (page.slots[i]) copy->slots[i] = std::make_unique<value_type>(*page.slots[i]);
    }
    return copy;
  }

  bool HasPage(size_t place, int64_t number) const { return place < pages_.size() && pages_[place].number == number; }

  /// Returns the index of the page, or the index at which to insert it.
  size_t PageIndex(int64_t number) const {
    if (pages_.empty() || number <= pages_.front().number) return 0;
    // The guess is exact if no page in between is missing; otherwise the index is smaller.
    const uint64_t guess = static_cast<uint64_t>(number) - static_cast<uint64_t>(pages_.front().number);
    const size_t last = static_cast<size_t>(std::min<uint64_t>(guess, pages_.size()));
    if (HasPage(last, number)) return last;
    const auto end = pages_.begin() + static_cast<std::ptrdiff_t>(last);
    const auto less = [](const Entry& entry, int64_t value) { return entry.number < value; };
    return static_cast<size_t>(std::lower_bound(pages_.begin(), end, number, less) - pages_.begin());
  }

  Page& PageFor(int64_t number) {
    const size_t place = PageIndex(number);
    if (!HasPage(place, number)) {
      pages_.insert(pages_.begin() + static_cast<std::ptrdiff_t>(place), Entry{number, std::make_unique<Page>()});
    }
    return *pages_[place].page;
  }

  std::vector<Entry> pages_;  // ascending by number; no page is empty
  size_t size_ = 0;
};

}  // namespace plslam
