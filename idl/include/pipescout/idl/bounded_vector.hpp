// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pipescout {

/// A std::vector with at most `UpperBound` elements, for the bounded sequences of messages
/// (`T[<=N]`): a function that would exceed the bound throws std::length_error and does not change
/// the elements.
template <class T, std::size_t UpperBound>
class BoundedVector {
  using Vector = std::vector<T>;

 public:
  using value_type = typename Vector::value_type;
  using size_type = typename Vector::size_type;
  using difference_type = typename Vector::difference_type;
  using reference = typename Vector::reference;
  using const_reference = typename Vector::const_reference;
  using pointer = typename Vector::pointer;
  using const_pointer = typename Vector::const_pointer;
  using iterator = typename Vector::iterator;
  using const_iterator = typename Vector::const_iterator;
  using reverse_iterator = typename Vector::reverse_iterator;
  using const_reverse_iterator = typename Vector::const_reverse_iterator;

  BoundedVector() = default;
  explicit BoundedVector(size_type count) : elements_(checked(count)) {}
  BoundedVector(size_type count, const T& value) : elements_(checked(count), value) {}
  BoundedVector(std::initializer_list<T> values) { assign(values); }
  BoundedVector(Vector values) { *this = std::move(values); }
  template <std::forward_iterator Iterator>
  BoundedVector(Iterator first, Iterator last) {
    assign(first, last);
  }

  BoundedVector& operator=(std::initializer_list<T> values) {
    assign(values);
    return *this;
  }
  BoundedVector& operator=(Vector values) {
    checked(values.size());
    elements_ = std::move(values);
    return *this;
  }

  void assign(size_type count, const T& value) { elements_.assign(checked(count), value); }
  void assign(std::initializer_list<T> values) {
    checked(values.size());
    elements_.assign(values);
  }
  template <std::forward_iterator Iterator>
  void assign(Iterator first, Iterator last) {
    checked(static_cast<size_type>(std::distance(first, last)));
    elements_.assign(first, last);
  }

  [[nodiscard]] bool empty() const noexcept { return elements_.empty(); }
  [[nodiscard]] size_type size() const noexcept { return elements_.size(); }
  [[nodiscard]] static constexpr size_type max_size() noexcept { return UpperBound; }
  [[nodiscard]] size_type capacity() const noexcept { return elements_.capacity(); }
  void reserve(size_type count) { elements_.reserve(checked(count)); }
  void shrink_to_fit() { elements_.shrink_to_fit(); }
  void resize(size_type count) { elements_.resize(checked(count)); }
  void resize(size_type count, const T& value) { elements_.resize(checked(count), value); }
  void clear() noexcept { elements_.clear(); }

  [[nodiscard]] reference operator[](size_type index) { return elements_[index]; }
  [[nodiscard]] const_reference operator[](size_type index) const { return elements_[index]; }
  [[nodiscard]] reference at(size_type index) { return elements_.at(index); }
  [[nodiscard]] const_reference at(size_type index) const { return elements_.at(index); }
  [[nodiscard]] reference front() { return elements_.front(); }
  [[nodiscard]] const_reference front() const { return elements_.front(); }
  [[nodiscard]] reference back() { return elements_.back(); }
  [[nodiscard]] const_reference back() const { return elements_.back(); }
  [[nodiscard]] auto* data() noexcept { return elements_.data(); }
  [[nodiscard]] const auto* data() const noexcept { return elements_.data(); }

  [[nodiscard]] iterator begin() noexcept { return elements_.begin(); }
  [[nodiscard]] const_iterator begin() const noexcept { return elements_.begin(); }
  [[nodiscard]] const_iterator cbegin() const noexcept { return elements_.cbegin(); }
  [[nodiscard]] iterator end() noexcept { return elements_.end(); }
  [[nodiscard]] const_iterator end() const noexcept { return elements_.end(); }
  [[nodiscard]] const_iterator cend() const noexcept { return elements_.cend(); }
  [[nodiscard]] reverse_iterator rbegin() noexcept { return elements_.rbegin(); }
  [[nodiscard]] const_reverse_iterator rbegin() const noexcept { return elements_.rbegin(); }
  [[nodiscard]] reverse_iterator rend() noexcept { return elements_.rend(); }
  [[nodiscard]] const_reverse_iterator rend() const noexcept { return elements_.rend(); }

  void push_back(const T& value) {
    checked(size() + 1);
    elements_.push_back(value);
  }
  void push_back(T&& value) {
    checked(size() + 1);
    elements_.push_back(std::move(value));
  }
  template <class... Arguments>
  decltype(auto) emplace_back(Arguments&&... arguments) {
    checked(size() + 1);
    return elements_.emplace_back(std::forward<Arguments>(arguments)...);
  }
  void pop_back() { elements_.pop_back(); }
  iterator insert(const_iterator position, const T& value) {
    checked(size() + 1);
    return elements_.insert(position, value);
  }
  iterator insert(const_iterator position, T&& value) {
    checked(size() + 1);
    return elements_.insert(position, std::move(value));
  }
  template <std::forward_iterator Iterator>
  iterator insert(const_iterator position, Iterator first, Iterator last) {
    checked(size() + static_cast<size_type>(std::distance(first, last)));
    return elements_.insert(position, first, last);
  }
  iterator erase(const_iterator position) { return elements_.erase(position); }
  iterator erase(const_iterator first, const_iterator last) { return elements_.erase(first, last); }
  void swap(BoundedVector& other) noexcept { elements_.swap(other.elements_); }

  /// The underlying vector.
  [[nodiscard]] const Vector& vector() const noexcept { return elements_; }

  bool operator==(const BoundedVector&) const = default;
  auto operator<=>(const BoundedVector&) const = default;
  friend bool operator==(const BoundedVector& left, const Vector& right) {
    return left.elements_ == right;
  }

 private:
  static size_type checked(size_type count) {
    if (count > UpperBound) {
      throw std::length_error("a sequence of at most " + std::to_string(UpperBound) +
                              " elements was to hold " + std::to_string(count));
    }
    return count;
  }

  Vector elements_;
};

}  // namespace pipescout
