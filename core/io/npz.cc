#include "core/io/npz.h"

#include <glog/logging.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/input_file.h"

namespace arborslam {
namespace {

constexpr char kSuffix[] = ".npy";
constexpr char kMagic[] = "\x93NUMPY";
constexpr char kDamagedRemedy[] = "copy or record the file again";
constexpr uint64_t kMaxArrayBytes = uint64_t{2} << 30;
constexpr size_t kMaxHeaderBytes = 1 << 16;
constexpr size_t kMaxAxes = 64;
// Deflate needs at least two bits, a length and a distance, for 258 bytes (RFC 1951).
constexpr uint64_t kMaxDeflateRatio = 1032;
constexpr size_t kChunkElements = 8192;

enum class ElementType { kFloat32, kFloat64, kInt32, kInt64 };

size_t SizeOf(ElementType type) { return type == ElementType::kFloat32 || type == ElementType::kInt32 ? 4 : 8; }

struct NpyHeader {
  ElementType type = ElementType::kFloat64;
  bool fortran_order = false;
  std::vector<size_t> shape;
};

// The number of elements of `shape`, or nothing when an array of them would be larger than allowed.
std::optional<uint64_t> NumElements(const std::vector<size_t>& shape) {
  if (std::count(shape.begin(), shape.end(), size_t{0}) > 0) return 0;
  uint64_t product = 1;
  for (const size_t length : shape) {
    if (length > kMaxArrayBytes / sizeof(double) / product) return std::nullopt;
    product *= length;
  }
  return product;
}

// Reads the Python dictionary of an .npy header: exactly the keys 'descr', 'fortran_order' and 'shape'.
class HeaderParser {
 public:
  HeaderParser(std::string_view text, const std::string& place) : rest_(text), place_(place) {}

  NpyHeader Parse() {
    NpyHeader header;
    bool has_descr = false;
    bool has_order = false;
    bool has_shape = false;
    Expect('{');
    while (!Accept('}')) {
      const std::string key = String();
      Expect(':');
      bool* const seen = key == "descr"           ? &has_descr
                         : key == "fortran_order" ? &has_order
                         : key == "shape"         ? &has_shape
                                                  : nullptr;
      if (seen == nullptr || *seen) Fail("the key " + Quoted(key) + " is unknown or given twice");
      *seen = true;
      if (seen == &has_descr) header.type = Type();
      if (seen == &has_order) header.fortran_order = Bool();
      if (seen == &has_shape) header.shape = Shape();
      if (!Accept(',')) {
        Expect('}');
        break;
      }
    }
    SkipSpace();
    if (!rest_.empty()) Fail("something follows the dictionary");
    if (!has_descr || !has_order || !has_shape) Fail("'descr', 'fortran_order' or 'shape' is missing");
    return header;
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) const {
    throw UserError(place_, "has a malformed .npy header: " + reason, kDamagedRemedy);
  }

  void SkipSpace() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\n"), rest_.size())); }

  bool Accept(char symbol) {
    SkipSpace();
    if (rest_.empty() || rest_.front() != symbol) return false;
    rest_.remove_prefix(1);
    return true;
  }

  void Expect(char symbol) {
    if (!Accept(symbol)) Fail(std::string("'") + symbol + "' expected at " + Quoted(std::string(rest_)));
  }

  bool AcceptWord(std::string_view word) {
    SkipSpace();
    if (rest_.substr(0, word.size()) != word) return false;
    rest_.remove_prefix(word.size());
    return true;
  }

  std::string String() {
    const char quote = Accept('"') ? '"' : '\'';
    if (quote == '\'') Expect('\'');
    const size_t length = rest_.find(quote);
    if (length == std::string_view::npos) Fail("a string has no end");
    const std::string string(rest_.substr(0, length));
    rest_.remove_prefix(length + 1);
    return string;
  }

  ElementType Type() {
    SkipSpace();
    const bool is_record = !rest_.empty() && rest_.front() == '[';
    const std::string name = is_record ? "" : String();
    if (name == "<f4") return ElementType::kFloat32;
    if (name == "<f8") return ElementType::kFloat64;
    if (name == "<i4") return ElementType::kInt32;
    if (name == "<i8") return ElementType::kInt64;
    throw UserError(place_, "has elements of type " + (is_record ? "record" : Quoted(name)),
                    "save it as float32, float64, int32 or int64, little-endian");
  }

  bool Bool() {
    if (AcceptWord("True")) return true;
    if (!AcceptWord("False")) Fail("'fortran_order' is neither True nor False");
    return false;
  }

  std::vector<size_t> Shape() {
    std::vector<size_t> shape;
    Expect('(');
    while (!Accept(')')) {
      shape.push_back(Length());
      if (shape.size() > kMaxAxes) Fail("it has more than " + std::to_string(kMaxAxes) + " axes");
      if (Accept(',')) continue;
      // A single number in parentheses is no tuple in Python.
      if (shape.size() == 1) Fail("'shape' is not a tuple");
      Expect(')');
      break;
    }
    return shape;
  }

  size_t Length() {
    SkipSpace();
    size_t length = 0;
    size_t digits = 0;
    for (; digits < rest_.size() && rest_[digits] >= '0' && rest_[digits] <= '9'; ++digits) {
      if (length > kMaxArrayBytes) Fail("an axis is longer than any array read here");
      length = 10 * length + static_cast<size_t>(rest_[digits] - '0');
    }
    if (digits == 0) Fail("a length expected at " + Quoted(std::string(rest_)));
    rest_.remove_prefix(digits);
    AcceptWord("L");  // Python 2 wrote long integers so.
    return length;
  }

  std::string_view rest_;
  const std::string& place_;
};

// The uncompressed bytes of one archive entry.
class EntryStream {
 public:
  EntryStream(zip_t* archive, uint64_t index, const std::string& place)
      : place_(place), file_(zip_fopen_index(archive, index, 0)) {
    if (file_ == nullptr) {
      throw UserError(place_, std::string("cannot be unpacked: ") + zip_strerror(archive), kDamagedRemedy);
    }
  }
  ~EntryStream() { zip_fclose(file_); }
  EntryStream(const EntryStream&) = delete;
  EntryStream& operator=(const EntryStream&) = delete;

  void ReadExactly(char* bytes, size_t size) {
    while (size > 0) {
      const size_t count = ReadSome(bytes, size);
      if (count == 0) throw UserError(place_, "ends before its header says", kDamagedRemedy);
      bytes += count;
      size -= count;
    }
  }

  // libzip compares the checksum when the end is read, so this is more than a check of the length.
  void ExpectEnd() {
    char surplus = 0;
    if (ReadSome(&surplus, 1) != 0) throw UserError(place_, "goes on after its header says", kDamagedRemedy);
  }

 private:
  size_t ReadSome(char* bytes, size_t size) {
    const zip_int64_t count = zip_fread(file_, bytes, size);
    if (count < 0) {
      throw UserError(place_, std::string("cannot be unpacked: ") + zip_file_strerror(file_), kDamagedRemedy);
    }
    return static_cast<size_t>(count);
  }

  const std::string& place_;
  zip_file_t* file_;
};

uint64_t LittleEndian(const char* bytes, size_t size) {
  uint64_t value = 0;
  for (size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

template <typename To, typename From>
double Reinterpret(From bits) {
  static_assert(sizeof(To) == sizeof(From));
  To value;
  std::memcpy(&value, &bits, sizeof(value));
  return static_cast<double>(value);
}

double Decode(ElementType type, const char* bytes) {
  const uint64_t bits = LittleEndian(bytes, SizeOf(type));
  switch (type) {
    case ElementType::kFloat32:
      return Reinterpret<float>(static_cast<uint32_t>(bits));
    case ElementType::kInt32:
      return Reinterpret<int32_t>(static_cast<uint32_t>(bits));
    case ElementType::kInt64:
      return Reinterpret<int64_t>(bits);
    case ElementType::kFloat64:
      break;
  }
  return Reinterpret<double>(bits);
}

// Reads magic, version and dictionary; `header_bytes` is how many bytes those were.
NpyHeader ReadHeader(EntryStream* stream, uint64_t entry_bytes, const std::string& place, uint64_t* header_bytes) {
  std::array<char, 8> start;
  if (entry_bytes < start.size()) throw UserError(place, "is too short for an .npy header", kDamagedRemedy);
  stream->ReadExactly(start.data(), start.size());
  if (std::memcmp(start.data(), kMagic, 6) != 0) {
    throw UserError(place, "is not in .npy format", "save it with numpy.savez");
  }
  const int version = static_cast<unsigned char>(start[6]);
  if (version < 1 || version > 3 || start[7] != 0) {
    throw UserError(place,
                    "has .npy format version " + std::to_string(version) + "." +
                        std::to_string(static_cast<unsigned char>(start[7])),
                    "save it in version 1.0, 2.0 or 3.0");
  }
  const size_t length_bytes = version == 1 ? 2 : 4;
  std::array<char, 4> length_field;
  stream->ReadExactly(length_field.data(), length_bytes);
  const uint64_t length = LittleEndian(length_field.data(), length_bytes);
  *header_bytes = start.size() + length_bytes + length;
  if (length > kMaxHeaderBytes || *header_bytes > entry_bytes) {
    throw UserError(place, "has a malformed .npy header: it claims " + std::to_string(length) + " bytes",
                    kDamagedRemedy);
  }
  std::string text(length, '\0');
  stream->ReadExactly(text.data(), text.size());
  return HeaderParser(text, place).Parse();
}

// `values` in Fortran order (the first axis runs fastest) put into row-major order.
std::vector<double> RowMajor(const std::vector<double>& values, const std::vector<size_t>& shape) {
  std::vector<double> ordered;
  ordered.reserve(values.size());
  std::vector<size_t> index(shape.size(), 0);
  while (ordered.size() < values.size()) {
    size_t offset = 0;
    for (size_t axis = shape.size(); axis-- > 0;) offset = offset * shape[axis] + index[axis];
    ordered.push_back(values[offset]);
    for (size_t axis = shape.size(); axis-- > 0 && ++index[axis] == shape[axis];) index[axis] = 0;
  }
  return ordered;
}

// An array as the bytes of an .npy file, version 1.
std::string EncodeNpy(const NpyArray& array) {
  std::string dictionary = "{'descr': '<f8', 'fortran_order': False, 'shape': " + array.ShapeText() + ", }";
  const size_t start_bytes = 10;
  // The data begin at a multiple of 64 bytes, and a line end is the header's last.
  dictionary.append(63 - (start_bytes + dictionary.size()) % 64, ' ');
  dictionary.push_back('\n');
  std::string bytes = kMagic;
  bytes.append({'\1', '\0', static_cast<char>(dictionary.size() & 0xff), static_cast<char>(dictionary.size() >> 8)});
  bytes += dictionary;
  bytes.reserve(bytes.size() + 8 * array.values.size());
  for (const double value : array.values) {
    uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    for (int shift = 0; shift < 64; shift += 8) bytes.push_back(static_cast<char>(bits >> shift & 0xff));
  }
  return bytes;
}

}  // namespace

std::string NpyArray::ShapeText() const {
  std::string text = "(";
  for (size_t axis = 0; axis < shape.size(); ++axis) {
    text += (axis == 0 ? "" : ", ") + std::to_string(shape[axis]);
  }
  return text + (shape.size() == 1 ? ",)" : ")");
}

void NpzFile::Closer::operator()(zip* archive) const { zip_discard(archive); }

NpzFile::NpzFile(const std::string& path) : path_(path) {
  if (!HasZipMagic(path)) throw UserError(path, "is not a NumPy zip", "save it with numpy.savez_compressed");
  int code = 0;
  archive_.reset(zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (archive_ == nullptr) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string reason = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw UserError(path, "is a damaged or incomplete zip archive (" + reason + ")", kDamagedRemedy);
  }
  const zip_int64_t num_entries = zip_get_num_entries(archive_.get(), 0);
  for (zip_int64_t i = 0; i < num_entries; ++i) {
    const uint64_t index = static_cast<uint64_t>(i);
    const char* name = zip_get_name(archive_.get(), index, 0);
    std::string key = name == nullptr ? "" : name;
    const size_t suffix_length = sizeof(kSuffix) - 1;
    if (key.size() <= suffix_length || key.compare(key.size() - suffix_length, suffix_length, kSuffix) != 0) continue;
    key.resize(key.size() - suffix_length);
    if (!entries_.emplace(key, index).second) {
      throw UserError(path, "holds the array " + Quoted(key) + " twice", kDamagedRemedy);
    }
  }
}

std::vector<std::string> NpzFile::Keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, index] : entries_) keys.push_back(key);
  return keys;
}

std::string NpzFile::KeyList() const {
  constexpr size_t kMaxListed = 20;
  std::string list;
  size_t listed = 0;
  for (const auto& [key, index] : entries_) {
    if (listed++ == kMaxListed) return list + ", ...";
    list += (list.empty() ? "" : ", ") + Quoted(key);
  }
  return list.empty() ? "no arrays" : list;
}

std::string NpzFile::Place(const std::string& key) const { return path_ + ", array '" + key + "'"; }

NpyArray NpzFile::Read(const std::string& key) const {
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) {
    throw UserError(path_, "has no array '" + key + "'", "give a file that has it (this one holds " + KeyList() + ")");
  }
  const std::string place = Place(key);
  zip_stat_t status;
  constexpr zip_uint64_t kNeeded = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
  if (zip_stat_index(archive_.get(), entry->second, 0, &status) != 0 || (status.valid & kNeeded) != kNeeded) {
    throw UserError(place, "has a damaged entry in the zip archive", kDamagedRemedy);
  }
  const bool stored = status.comp_method == ZIP_CM_STORE;
  if (!stored && status.comp_method != ZIP_CM_DEFLATE) {
    throw UserError(place, "is compressed by method " + std::to_string(status.comp_method),
                    "save it with numpy.savez_compressed");
  }
  if (stored ? status.size != status.comp_size : status.size / kMaxDeflateRatio > status.comp_size) {
    throw UserError(place,
                    "declares " + std::to_string(status.size) + " bytes, more than its " +
                        std::to_string(status.comp_size) + " packed bytes can hold",
                    kDamagedRemedy);
  }

  EntryStream stream(archive_.get(), entry->second, place);
  uint64_t header_bytes = 0;
  const NpyHeader header = ReadHeader(&stream, status.size, place, &header_bytes);
  NpyArray array;
  array.shape = header.shape;
  const std::optional<uint64_t> count = NumElements(header.shape);
  if (!count) {
    throw UserError(place,
                    "has the shape " + array.ShapeText() + ", larger than the " + std::to_string(kMaxArrayBytes >> 30) +
                        " GiB read at most",
                    "split the recording");
  }
  const size_t element_bytes = SizeOf(header.type);
  if (header_bytes + *count * element_bytes != status.size) {
    throw UserError(place,
                    "has " + std::to_string(status.size) + " bytes where its shape " + array.ShapeText() + " needs " +
                        std::to_string(header_bytes + *count * element_bytes),
                    kDamagedRemedy);
  }
  // The memory grows with the data that really come, not with what the header promises.
  std::vector<char> chunk(kChunkElements * element_bytes);
  for (uint64_t remaining = *count; remaining > 0;) {
    const size_t elements = static_cast<size_t>(std::min<uint64_t>(remaining, kChunkElements));
    stream.ReadExactly(chunk.data(), elements * element_bytes);
    for (size_t i = 0; i < elements; ++i) array.values.push_back(Decode(header.type, &chunk[i * element_bytes]));
    remaining -= elements;
  }
  stream.ExpectEnd();
  if (header.fortran_order && array.shape.size() > 1) array.values = RowMajor(array.values, array.shape);
  return array;
}

void WriteNpz(const std::string& path, const std::map<std::string, NpyArray>& arrays) {
  std::vector<std::string> contents;  // Borrowed by the archive until it is closed.
  contents.reserve(arrays.size());
  zip_error_t error;
  zip_error_init(&error);
  // libzip names its files itself, so the archive is made in memory and written by AtomicFile.
  zip_source_t* const memory = zip_source_buffer_create(nullptr, 0, 0, &error);
  CHECK(memory != nullptr) << zip_error_strerror(&error);
  zip_source_keep(memory);
  zip_t* const archive = zip_open_from_source(memory, ZIP_TRUNCATE, &error);
  CHECK(archive != nullptr) << zip_error_strerror(&error);
  for (const auto& [key, array] : arrays) {
    CHECK(NumElements(array.shape) == array.values.size()) << "array " << key << " of shape " << array.ShapeText();
    contents.push_back(EncodeNpy(array));
    zip_source_t* const source = zip_source_buffer(archive, contents.back().data(), contents.back().size(), 0);
    const zip_int64_t index = zip_file_add(archive, (key + kSuffix).c_str(), source, ZIP_FL_ENC_UTF_8);
    CHECK_GE(index, 0) << zip_strerror(archive);
    // The first moment the format knows, 1 January 1980: the time of writing would make equal arrays differ.
    CHECK_EQ(zip_file_set_dostime(archive, static_cast<zip_uint64_t>(index), 0, 1 << 5 | 1, 0), 0);
  }
  CHECK_EQ(zip_close(archive), 0) << zip_strerror(archive);

  zip_stat_t status;
  CHECK_EQ(zip_source_stat(memory, &status), 0);
  std::string bytes(status.size, '\0');
  CHECK_EQ(zip_source_open(memory), 0);
  CHECK_EQ(zip_source_read(memory, bytes.data(), bytes.size()), static_cast<zip_int64_t>(bytes.size()));
  zip_source_close(memory);
  zip_source_free(memory);
  WriteFileAtomically(path, bytes);
}

}  // namespace arborslam
