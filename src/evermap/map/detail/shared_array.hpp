// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace evermap {

/// An array whose copies share their elements until one of them changes some: copying takes no time, and the
/// first change after it copies the elements. One pointer in size; elements follow the header in memory.
///
/// Copies in different threads may be read, changed and destroyed independently of each other. One and the
/// same array is like a std::vector: const members may be called from several threads at once, the others
/// need exclusive access.
template <class T>
class SharedArray {
 public:
  SharedArray() = default;
  explicit SharedArray(std::vector<T> elements) {
    reserve(elements.size());
    std::uninitialized_move(elements.begin(), elements.end(), begin_of(header_));
    set_size(elements.size());
  }
  SharedArray(const SharedArray& other) noexcept : header_(other.header_) {
    if (header_ != nullptr) header_->owners.fetch_add(1, std::memory_order_relaxed);
  }
  SharedArray(SharedArray&& other) noexcept : header_(std::exchange(other.header_, nullptr)) {}
  SharedArray& operator=(SharedArray other) noexcept {
    std::swap(header_, other.header_);
    return *this;
  }
  ~SharedArray() { release(header_); }

  std::size_t size() const { return header_ != nullptr ? header_->size : 0; }
  std::size_t capacity() const { return header_ != nullptr ? header_->capacity : 0; }
  bool empty() const { return size() == 0; }
  const T* data() const { return header_ != nullptr ? begin_of(header_) : nullptr; }
  const T& operator[](std::size_t i) const { return begin_of(header_)[i]; }  ///< REQUIRES: i < size()

  /// The element, for changing it: no other array sees the change. REQUIRES: i < size().
  T& own(std::size_t i) {
    if (is_shared()) reallocate(header_->capacity);
    return begin_of(header_)[i];
  }

  /// Inserts T{} before element `at` and returns it. Grows by a quarter: most of a map's memory is here.
  T& insert(std::size_t at) {
    const std::size_t count = size();
    if (count == capacity()) {
      reallocate(count + 1 + count / 4);
    } else if (is_shared()) {
      reallocate(capacity());
    }
    T* elements = begin_of(header_);
    std::construct_at(elements + count);
    set_size(count + 1);
    std::rotate(elements + at, elements + count, elements + count + 1);
    return elements[at] = T{};
  }

  /// REQUIRES: at < size().
  void erase(std::size_t at) {
    if (is_shared()) reallocate(header_->capacity);
    T* elements = begin_of(header_);
    std::move(elements + at + 1, elements + size(), elements + at);
    std::destroy_at(elements + size() - 1);
    set_size(size() - 1);
  }

 private:
  struct alignas(std::max_align_t) Header {
    std::atomic<std::uint32_t> owners{1};
    std::uint32_t size = 0;
    std::uint32_t capacity = 0;
  };
  static_assert(alignof(T) <= alignof(Header));

  static T* begin_of(Header* header) { return std::launder(reinterpret_cast<T*>(header + 1)); }

  bool is_shared() const { return header_ != nullptr && header_->owners.load(std::memory_order_acquire) > 1; }
  void set_size(std::size_t size) {
    if (header_ != nullptr) header_->size = static_cast<std::uint32_t>(size);
  }

  static Header* allocate(std::size_t capacity) {
    auto* header = new (::operator new(sizeof(Header) + capacity * sizeof(T))) Header;
    header->capacity = static_cast<std::uint32_t>(capacity);
    return header;
  }
  void reserve(std::size_t capacity) {
    if (capacity > 0) header_ = allocate(capacity);
  }

  /// Moves to memory of its own with room for `capacity` elements; copies them when others still need them.
  void reallocate(std::size_t capacity) {
    Header* fresh = allocate(capacity);
    if (header_ != nullptr) {
      T* elements = begin_of(header_);
      if (is_shared()) {
        std::uninitialized_copy_n(elements, size(), begin_of(fresh));
      } else {
        std::uninitialized_move_n(elements, size(), begin_of(fresh));
      }
      fresh->size = header_->size;
    }
    release(std::exchange(header_, fresh));
  }

  static void release(Header* header) {
    if (header == nullptr || header->owners.fetch_sub(1, std::memory_order_acq_rel) > 1) return;
    std::destroy_n(begin_of(header), header->size);
    header->~Header();
    ::operator delete(header);
  }

  Header* header_ = nullptr;
};

}  // namespace evermap
