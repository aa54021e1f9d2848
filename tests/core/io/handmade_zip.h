#ifndef ARBORSLAM_TESTS_CORE_IO_HANDMADE_ZIP_H_
#define ARBORSLAM_TESTS_CORE_IO_HANDMADE_ZIP_H_

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

namespace arborslam {

/// `value` as `size` bytes, the least first.
inline std::string LittleEndianBytes(uint64_t value, size_t size) {
  std::string bytes;
  for (size_t i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xff));
  return bytes;
}

inline uint32_t Crc32(const std::string& bytes) {
  uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1u ? 0xedb88320u : 0u);
  }
  return ~crc;
}

/// One entry of a zip archive made by hand, true or lying.
struct HandmadeEntry {
  std::string name;
  std::string bytes;                      ///< As they stand in the archive.
  std::optional<uint64_t> declared_size;  ///< Uncompressed, where it differs from the bytes' number.
  uint16_t method = 0;                    ///< 0 stored, 8 deflated.
};

/// A zip archive of these entries, laid out as APPNOTE.TXT says, with zip64 sizes throughout.
/// `declared_entries`: the number of entries that the end record claims, where it is not the true one.
inline std::string HandmadeZip(const std::vector<HandmadeEntry>& entries,
                               std::optional<uint64_t> declared_entries = std::nullopt) {
  std::string archive;
  std::string directory;
  for (const HandmadeEntry& entry : entries) {
    const uint64_t size = entry.declared_size.value_or(entry.bytes.size());
    const std::string sizes = LittleEndianBytes(1, 2) + LittleEndianBytes(16, 2) + LittleEndianBytes(size, 8) +
                              LittleEndianBytes(entry.bytes.size(), 8);
    const std::string common = LittleEndianBytes(45, 2) + LittleEndianBytes(0, 2) + LittleEndianBytes(entry.method, 2) +
                               LittleEndianBytes(0, 2) + LittleEndianBytes(33, 2) +
                               LittleEndianBytes(Crc32(entry.bytes), 4) + LittleEndianBytes(0xffffffffu, 4) +
                               LittleEndianBytes(0xffffffffu, 4) + LittleEndianBytes(entry.name.size(), 2) +
                               LittleEndianBytes(sizes.size(), 2);
    directory += "PK\1\2" + LittleEndianBytes(45, 2) + common + LittleEndianBytes(0, 2) + LittleEndianBytes(0, 2) +
                 LittleEndianBytes(0, 2) + LittleEndianBytes(0, 4) + LittleEndianBytes(archive.size(), 4) + entry.name +
                 sizes;
    archive += "PK\3\4" + common + entry.name + sizes + entry.bytes;
  }
  const uint64_t directory_offset = archive.size();
  const uint64_t count = declared_entries.value_or(entries.size());
  archive += directory;
  const uint64_t end_offset = archive.size();
  archive += "PK\6\6" + LittleEndianBytes(44, 8) + LittleEndianBytes(45, 2) + LittleEndianBytes(45, 2) +
             LittleEndianBytes(0, 4) + LittleEndianBytes(0, 4) + LittleEndianBytes(count, 8) +
             LittleEndianBytes(count, 8) + LittleEndianBytes(directory.size(), 8) +
             LittleEndianBytes(directory_offset, 8);
  archive += "PK\6\7" + LittleEndianBytes(0, 4) + LittleEndianBytes(end_offset, 8) + LittleEndianBytes(1, 4);
  archive += "PK\5\6" + LittleEndianBytes(0, 4) + LittleEndianBytes(0xffff, 2) + LittleEndianBytes(0xffff, 2) +
             LittleEndianBytes(0xffffffffu, 4) + LittleEndianBytes(0xffffffffu, 4) + LittleEndianBytes(0, 2);
  return archive;
}

/// An .npy file of version 1 with this dictionary and data, both as given.
inline std::string HandmadeNpy(const std::string& dictionary, const std::string& data, char version = 1) {
  const std::string header = dictionary + "\n";
  return std::string("\x93NUMPY") + version + '\0' + LittleEndianBytes(header.size(), version == 1 ? 2 : 4) + header +
         data;
}

inline std::string Dictionary(const std::string& type, const std::string& order, const std::string& shape) {
  return "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
}

/// The values one after the other as little-endian T.
template <typename T>
std::string RawValues(const std::vector<T>& values) {
  std::string bytes;
  for (const T value : values) {
    uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(T));
    bytes += LittleEndianBytes(bits, sizeof(T));
  }
  return bytes;
}

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_CORE_IO_HANDMADE_ZIP_H_
