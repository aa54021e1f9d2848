#ifndef ARBORSLAM_CORE_IO_TEXT_READER_H_
#define ARBORSLAM_CORE_IO_TEXT_READER_H_

#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

namespace arborslam {

/// Reads a text file of records, one a line, fields apart by white space. Blank lines and lines that begin with '#'
/// are skipped. Numbers are read independently of the locale. All errors are `UserError`s that name file and line.
class TextReader {
 public:
  /// Opens the file at `path`; throws as `OpenInputFile` does.
  explicit TextReader(const std::string& path);

  /// Goes to the next record; false at the end of the file. Throws on a line too long to be text.
  bool Next();

  /// The fields of the current record, at least one.
  const std::vector<std::string>& fields() const { return fields_; }

  /// The current record's line, counted from 1.
  size_t line_number() const { return line_number_; }

  /// "path, line 12": the place of the current record for an error.
  std::string Place() const { return Place(line_number_); }
  std::string Place(size_t line_number) const;

  /// Throws unless the current record has `count` fields; `layout` names them for the message.
  void ExpectFields(size_t count, const std::string& layout) const;

  /// Field `index` as a finite number; `name` is what the message calls it.
  double Number(size_t index, const std::string& name) const;

  /// Field `index` as an integer that fits an int.
  int Integer(size_t index, const std::string& name) const;

 private:
  std::string path_;
  std::ifstream stream_;
  size_t line_number_ = 0;
  std::vector<char> line_;
  std::vector<std::string> fields_;
};

/// The shortest text that reads back as exactly `value`, independently of the locale.
std::string ShortestText(double value);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_TEXT_READER_H_
