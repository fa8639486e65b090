// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"

/// Conversion of values to bytes and back, to the last bit: little endian, one after the other, containers after their
/// number of elements, an optional value after a byte that is 1 if there is a value and else 0.
///
/// A type lists its fields once, for writing and for reading:
///
///   template <class Archive, class Self>
///   static void Fields(Archive& a, Self& self) { a(self.id, self.pose); }   // a member, also of private fields
///
/// or as a free function `Fields(Archive&, T&)` in this namespace, where the layout belongs to a format and not to
/// the type.
namespace plslam::archive {

static_assert(std::endian::native == std::endian::little, "values are copied byte by byte");

template <class T, class Of>
concept Is = std::same_as<std::remove_const_t<T>, Of>;

template <class T>
struct IsArrayOfNumbers : std::false_type {};
template <class T, size_t n>
struct IsArrayOfNumbers<std::array<T, n>> : std::is_arithmetic<T> {};

/// Copied as it lies in memory.
template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T> || IsArrayOfNumbers<T>::value ||
    (requires { T::SizeAtCompileTime; } && T::SizeAtCompileTime != Eigen::Dynamic);

class Writer {
 public:
  explicit Writer(size_t expected_bytes = 0) : bytes_(expected_bytes) {}
  /// Passes the written bytes to `sink`, about a megabyte at a time; call `Flush` at the end. The functions below refer
  /// to the bytes that have not been passed on.
  explicit Writer(std::function<void(std::span<const uint8_t>)> sink) : bytes_(1 << 20), sink_(std::move(sink)) {}
  void Flush() {
    sink_(Written());
    size_ = 0;
  }

  template <class... T>
  void operator()(const T&... values) {
    (Write(values), ...);
  }

  std::vector<uint8_t> Take() && {
    bytes_.resize(size_);
    return std::move(bytes_);
  }

  size_t size() const { return size_; }
  std::span<const uint8_t> Written() const { return {bytes_.data(), size_}; }
  /// Overwrites bytes that were written before.
  void Overwrite(size_t begin, const void* data, size_t n) { std::memcpy(bytes_.data() + begin, data, n); }

 private:
  void Append(const void* data, size_t n) {
    if (bytes_.size() - size_ < n) MakeRoom(n);
    if (n > 0) std::memcpy(bytes_.data() + size_, data, n);
    size_ += n;
  }
  void MakeRoom(size_t n) {
    if (sink_) Flush();
    if (bytes_.size() - size_ < n) bytes_.resize(2 * bytes_.size() + n + 64);
  }
  template <Plain T>
  void Write(const T& value) {
    Append(&value, sizeof(T));
  }
  void Write(const SE3& pose) { (*this)(pose.translation(), pose.rotation().coeffs()); }
  void Write(const std::string& text) {
    Write(static_cast<uint64_t>(text.size()));
    Append(text.data(), text.size());
  }
  template <class First, class Second>
  void Write(const std::pair<First, Second>& value) {
    (*this)(value.first, value.second);
  }
  template <class T>
  void Write(const std::optional<T>& value) {
    Write(static_cast<uint8_t>(value.has_value()));
    if (value) Write(*value);
  }
  template <class T>
  void Write(const std::vector<T>& values) {
    Write(std::span<const T>(values));
  }
  template <class T>
  void Write(std::span<const T> values) {
    Write(static_cast<uint64_t>(values.size()));
    if constexpr (std::is_arithmetic_v<T>) {
      Append(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) Write(value);
    }
  }
  template <class T>
  void Write(const std::deque<T>& values) {
    Write(static_cast<uint64_t>(values.size()));
    for (const T& value : values) Write(value);
  }
  template <class Key, class Value>
  void Write(const std::map<Key, Value>& values) {
    Write(static_cast<uint64_t>(values.size()));
    for (const auto& [key, value] : values) (*this)(key, value);
  }
  template <class T>
  void Write(const T& value) {
    if constexpr (requires { T::Fields(*this, value); }) {
      T::Fields(*this, value);
    } else {
      Fields(*this, value);
    }
  }

  // More than is used: a vector that grows value by value is three times slower.
  std::vector<uint8_t> bytes_;
  size_t size_ = 0;
  std::function<void(std::span<const uint8_t>)> sink_;
};

/// Throws std::runtime_error if the bytes end too early. Memory is proportional to the number of bytes, whatever sizes
/// they contain.
class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  template <class... T>
  void operator()(T&... values) {
    (Read(values), ...);
  }

  /// Returns the number of elements that follow, each of at least `min_bytes`.
  uint64_t ReadCount(size_t min_bytes) {
    uint64_t n = 0;
    Read(n);
    if (n > bytes_.size() / min_bytes) throw std::runtime_error("the content is shorter than it states");
    return n;
  }

  bool AtEnd() const { return bytes_.empty(); }

 private:
  void Copy(void* to, size_t n) {
    if (bytes_.size() < n) throw std::runtime_error("the content is truncated");
    if (n > 0) std::memcpy(to, bytes_.data(), n);
    bytes_ = bytes_.subspan(n);
  }
  template <Plain T>
  void Read(T& value) {
    Copy(&value, sizeof(T));
  }
  void Read(SE3& pose) {
    Eigen::Vector3d t;
    Eigen::Vector4d xyzw;
    (*this)(t, xyzw);
    pose = SE3::FromUnit(Eigen::Quaterniond(xyzw), t);
  }
  void Read(std::string& text) {
    text.resize(ReadCount(1));
    Copy(text.data(), text.size());
  }
  template <class First, class Second>
  void Read(std::pair<First, Second>& value) {
    (*this)(value.first, value.second);
  }
  template <class T>
  void Read(std::optional<T>& value) {
    uint8_t has_value = 0;
    Read(has_value);
    if (has_value > 1) throw std::runtime_error("the content states neither a value nor the lack of one");
    value.reset();
    if (has_value == 1) Read(value.emplace());
  }
  template <class T>
  void Read(std::vector<T>& values);
  template <class T>
  void Read(std::deque<T>& values);
  template <class Key, class Value>
  void Read(std::map<Key, Value>& values);
  template <class T>
  void Read(T& value) {
    if constexpr (requires { T::Fields(*this, value); }) {
      T::Fields(*this, value);
    } else {
      Fields(*this, value);
    }
  }

  std::span<const uint8_t> bytes_;
};

/// Returns the size of a value whose containers are empty.
template <class T>
size_t MinBytes() {
  static const size_t bytes = [] {
    Writer writer;
    writer(T());
    return std::move(writer).Take().size();
  }();
  return bytes;
}

template <class T>
void Reader::Read(std::vector<T>& values) {
  values.resize(ReadCount(MinBytes<T>()));
  if constexpr (std::is_arithmetic_v<T>) {
    Copy(values.data(), values.size() * sizeof(T));
  } else {
    for (T& value : values) Read(value);
  }
}

template <class T>
void Reader::Read(std::deque<T>& values) {
  values.resize(ReadCount(MinBytes<T>()));
  for (T& value : values) Read(value);
}

template <class Key, class Value>
void Reader::Read(std::map<Key, Value>& values) {
  values.clear();
  for (uint64_t n = ReadCount(MinBytes<Key>() + MinBytes<Value>()); n > 0; --n) {
    Key key{};
    Read(key);
    Read(values[key]);
  }
}

/// Returns the bytes of these values. The buffer has room for a little more than `expected_bytes`, for example the size
/// of the previous call, so that it need not be moved.
template <class... T>
std::vector<uint8_t> ToBytesOf(size_t expected_bytes, const T&... values) {
  Writer writer(expected_bytes + expected_bytes / 8);
  writer(values...);
  return std::move(writer).Take();
}

/// The bytes of these values.
template <class... T>
std::vector<uint8_t> ToBytes(const T&... values) {
  return ToBytesOf(0, values...);
}

/// The values that `ToBytes` made the bytes of. Throws std::runtime_error for bytes that are not as many.
template <class... T>
void FromBytes(std::span<const uint8_t> bytes, T&... values) {
  Reader read(bytes);
  read(values...);
  if (!read.AtEnd()) throw std::runtime_error("the content is longer than stated in its header");
}

}  // namespace plslam::archive
