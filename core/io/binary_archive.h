#ifndef ARBORSLAM_CORE_IO_BINARY_ARCHIVE_H_
#define ARBORSLAM_CORE_IO_BINARY_ARCHIVE_H_

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/geometry/se2.h"
#include "core/map/ids.h"

namespace arborslam {

// Values as bytes and back, bit by bit, in the byte order of the machine (little-endian on all that the project is
// built for). Knows numbers, enums, std::string, vector, deque, array, map and optional, Eigen matrices, SE2
// and ids; any other type says its fields, in one place for both directions:
//
//     template <class Visitor>
//     void VisitState(Visitor&& visit) {
//       visit(stamp, points);
//     }
//
// `std::decay_t<Visitor>::kIsReading` tells a type that has more to do after reading. What is written has no types and
// no names: who stores it says of which format version it is.

/// Appends values to a string of bytes.
class BinaryWriter {
 public:
  static constexpr bool kIsReading = false;

  /// Writes `values` in their order.
  template <class... Values>
  void operator()(const Values&... values) {
    (Write(values), ...);
  }

  const std::string& bytes() const { return bytes_; }

 private:
  void Raw(const void* data, size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  void Size(size_t size) { Write(static_cast<uint64_t>(size)); }
  template <class Range>
  void Elements(const Range& range) {
    for (const auto& element : range) Write(element);
  }

  template <class T>
  void Write(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      Raw(&value, sizeof(T));
    } else {
      // Visiting changes nothing while writing.
      const_cast<T&>(value).VisitState(*this);
    }
  }
  void Write(const std::string& text) {
    Size(text.size());
    Raw(text.data(), text.size());
  }
  template <class T>
  void Write(const std::vector<T>& values) {
    Size(values.size());
    if constexpr (std::is_arithmetic_v<T>) {
      Raw(values.data(), values.size() * sizeof(T));
    } else {
      Elements(values);
    }
  }
  template <class T>
  void Write(const std::deque<T>& values) {
    Size(values.size());
    Elements(values);
  }
  template <class T, size_t N>
  void Write(const std::array<T, N>& values) {
    Elements(values);
  }
  template <class Key, class T>
  void Write(const std::map<Key, T>& values) {
    Size(values.size());
    for (const auto& [key, value] : values) (*this)(key, value);
  }
  template <class T>
  void Write(const std::optional<T>& value) {
    Write(value.has_value());
    if (value) Write(*value);
  }
  template <class T, int kRows, int kCols, int kOptions>
  void Write(const Eigen::Matrix<T, kRows, kCols, kOptions>& matrix) {
    if constexpr (kRows == Eigen::Dynamic) Size(static_cast<size_t>(matrix.rows()));
    if constexpr (kCols == Eigen::Dynamic) Size(static_cast<size_t>(matrix.cols()));
    Raw(matrix.data(), static_cast<size_t>(matrix.size()) * sizeof(T));
  }
  void Write(const SE2& pose) { Write(pose.vector()); }
  template <class Kind>
  void Write(const Id<Kind>& id) {
    Write(id.value);
  }
  void Write(const NodeId& id) { (*this)(id.kind, id.value); }

  std::string bytes_;
};

/// Reads what a `BinaryWriter` wrote. Bytes that cannot be that are a `UserError`, never a crash.
class BinaryReader {
 public:
  static constexpr bool kIsReading = true;

  /// @param bytes  borrowed; must outlive the reader.
  /// @param place  names them in errors: "runs/session.db, keyframe 12".
  BinaryReader(std::string_view bytes, std::string place) : bytes_(bytes), place_(std::move(place)) {}

  /// Reads `values` in their order.
  template <class... Values>
  void operator()(Values&... values) {
    (Read(&values), ...);
  }

  /// Throws `UserError` unless `condition` holds of what was read; `problem` says what is wrong otherwise.
  void Check(bool condition, const char* problem) const {
    if (!condition) Fail(problem);
  }

  /// True if all bytes have been read.
  bool AtEnd() const { return bytes_.empty(); }

  /// Throws `UserError` unless all bytes have been read.
  void CheckEnd() const { Check(bytes_.empty(), "there is more than expected"); }

 private:
  [[noreturn]] void Fail(const char* problem) const {
    throw UserError(place_, std::string("is damaged: ") + problem, "use a copy, or map the recording again");
  }
  void Raw(void* data, size_t size) {
    if (size > bytes_.size()) Fail("it is cut short");
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }
  // A number of elements of `least_bytes` each at least.
  size_t Size(size_t least_bytes) {
    uint64_t size = 0;
    Read(&size);
    if (size > bytes_.size() / least_bytes) Fail("it is cut short");
    return static_cast<size_t>(size);
  }

  template <class T>
  void Read(T* value) {
    if constexpr (std::is_same_v<T, bool>) {
      uint8_t byte = 0;
      Raw(&byte, 1);
      if (byte > 1) Fail("a flag is neither 0 nor 1");
      *value = byte == 1;
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      Raw(value, sizeof(T));
    } else {
      value->VisitState(*this);
    }
  }
  void Read(std::string* text) {
    text->resize(Size(1));
    Raw(text->data(), text->size());
  }
  template <class T>
  void Read(std::vector<T>* values) {
    if constexpr (std::is_arithmetic_v<T>) {
      values->resize(Size(sizeof(T)));
      Raw(values->data(), values->size() * sizeof(T));
    } else {
      values->clear();
      values->resize(Size(1));
      for (T& value : *values) Read(&value);
    }
  }
  template <class T>
  void Read(std::deque<T>* values) {
    values->clear();
    values->resize(Size(1));
    for (T& value : *values) Read(&value);
  }
  template <class T, size_t N>
  void Read(std::array<T, N>* values) {
    for (T& value : *values) Read(&value);
  }
  template <class Key, class T>
  void Read(std::map<Key, T>* values) {
    values->clear();
    for (size_t left = Size(1); left > 0; --left) {
      std::pair<Key, T> entry;
      (*this)(entry.first, entry.second);
      if (!values->insert(std::move(entry)).second) Fail("an entry is there twice");
    }
  }
  template <class T>
  void Read(std::optional<T>* value) {
    bool has_value = false;
    Read(&has_value);
    value->reset();
    if (has_value) Read(&value->emplace());
  }
  template <class T, int kRows, int kCols, int kOptions>
  void Read(Eigen::Matrix<T, kRows, kCols, kOptions>* matrix) {
    if constexpr (kRows == Eigen::Dynamic || kCols == Eigen::Dynamic) {
      const size_t rows = kRows == Eigen::Dynamic ? Size(1) : static_cast<size_t>(kRows);
      const size_t cols = kCols == Eigen::Dynamic ? Size(1) : static_cast<size_t>(kCols);
      if (cols > 0 && rows > bytes_.size() / (cols * sizeof(T))) Fail("it is cut short");
      matrix->resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
    }
    Raw(matrix->data(), static_cast<size_t>(matrix->size()) * sizeof(T));
  }
  void Read(SE2* pose) {
    Eigen::Vector3d vector;
    Read(&vector);
    if (!vector.allFinite()) Fail("a pose is not finite");
    *pose = SE2(vector.x(), vector.y(), vector.z());
  }
  template <class Kind>
  void Read(Id<Kind>* id) {
    Read(&id->value);
  }
  void Read(NodeId* id) {
    (*this)(id->kind, id->value);
    Check(id->kind == NodeId::Kind::kKeyframe || id->kind == NodeId::Kind::kSubmap, "a node is of an unknown kind");
  }

  std::string_view bytes_;  // Those that are left.
  std::string place_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_BINARY_ARCHIVE_H_
