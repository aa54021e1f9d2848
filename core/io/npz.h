#ifndef ARBORSLAM_CORE_IO_NPZ_H_
#define ARBORSLAM_CORE_IO_NPZ_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

struct zip;

namespace arborslam {

/// A NumPy array as doubles.
struct NpyArray {
  std::vector<size_t> shape;   ///< Length of each axis; empty for a scalar.
  std::vector<double> values;  ///< Row-major (the last axis runs fastest), as many as the shape's product.

  /// The shape as Python prints it: "(546, 897)", "(546,)", "()".
  std::string ShapeText() const;
};

/// A NumPy zip archive (`numpy.savez`, `numpy.savez_compressed`), open for reading. The file is not trusted: sizes that
/// it declares are checked against each other and never allocated ahead of the data. Use from one thread.
///
/// Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html, versions 1 to 3.
class NpzFile {
 public:
  /// Reads the archive's directory. Throws `UserError` when `path` is missing, a folder, unreadable, empty, no zip
  /// archive, or a damaged one.
  explicit NpzFile(const std::string& path);

  const std::string& path() const { return path_; }

  bool Has(const std::string& key) const { return entries_.count(key) != 0; }

  /// The arrays' names, sorted.
  std::vector<std::string> Keys() const;

  /// The arrays' names for a message, quoted: "'scan0', 'time'".
  std::string KeyList() const;

  /// Reads the array `key`, stored as little-endian float32, float64, int32 or int64 (int64 beyond 2^53 is rounded) in
  /// C or Fortran order, at most 2 GiB as doubles. Throws `UserError` when there is no such array (the message lists
  /// those there are), its type is another, or its data are damaged or not as long as its header says.
  NpyArray Read(const std::string& key) const;

  /// "path, array 'key'": the place for an error about an array.
  std::string Place(const std::string& key) const;

 private:
  struct Closer {
    void operator()(zip* archive) const;
  };

  std::string path_;
  std::unique_ptr<zip, Closer> archive_;
  std::map<std::string, uint64_t> entries_;  // Index in the archive by key.
};

/// Writes `arrays` by name to a NumPy zip at `path`, as float64 and deflated; equal arrays give equal bytes. Throws
/// `UserError` when the file cannot be written. Each array must have as many values as its shape says.
void WriteNpz(const std::string& path, const std::map<std::string, NpyArray>& arrays);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_NPZ_H_
