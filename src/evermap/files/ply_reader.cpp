// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <evermap/files/detail/ply_reader.hpp>

namespace evermap {

PlyReader::PlyReader(const InputFile& file)
    : file_(file), lines_(file), header_(read_ply_header(file, lines_)), offset_(lines_.offset()) {}

void PlyReader::read_row(const PlyElement& element, PlyRow& row) {
  row.values_.clear();
  row.ends_.clear();
  if (is_ascii()) {
    read_text_row(element, row);
  } else {
    read_binary_row(element, row);
  }
}

void PlyReader::read_text_row(const PlyElement& element, PlyRow& row) {
  if (element.properties.empty()) return;
  next_line(element);
  std::vector<double>& values = row.values_;
  lines_.read_numbers(values);
  std::size_t end = 0;
  for (const PlyProperty& property : element.properties) {
    std::size_t count = 1;
    if (property.list_count_type) {
      const double following = static_cast<double>(values.size()) - static_cast<double>(end) - 1;
      const bool is_count = following >= 0 && values[end] >= 0 && values[end] <= following;
      if (!is_count) lines_.fail("a list of another length than it says; correct or remove the line");
      count = static_cast<std::size_t>(values[end]);
      values.erase(values.begin() + static_cast<std::ptrdiff_t>(end));
    }
    end += count;
    row.ends_.push_back(end);
  }
  if (end != values.size()) {
    lines_.fail("has " + std::to_string(values.size()) + " values instead of " + std::to_string(end) +
                "; correct or remove the line");
  }
}

void PlyReader::read_binary_row(const PlyElement& element, PlyRow& row) {
  for (const PlyProperty& property : element.properties) {
    std::uint64_t count = 1;
    if (property.list_count_type) {
      const std::size_t at = offset_;
      const char* bytes = take(element, 1, size_of(*property.list_count_type));
      const double length = decode(bytes, *property.list_count_type, order());
      if (length < 0) file_.fail_at_byte(at, "a list of negative length; write the file again");
      count = static_cast<std::uint64_t>(length);
    }
    const std::size_t size = size_of(property.type);
    const char* bytes = take(element, count, size);
    for (std::uint64_t i = 0; i < count; ++i) {
      row.values_.push_back(decode(bytes + i * size, property.type, order()));
    }
    row.ends_.push_back(row.values_.size());
  }
}

void PlyReader::skip(const PlyElement& element) {
  if (element.properties.empty()) return;
  if (is_ascii()) {
    for (std::uint64_t i = 0; i < element.count; ++i) next_line(element);
  } else if (element.has_list()) {
    PlyRow row;
    for (std::uint64_t i = 0; i < element.count; ++i) read_row(element, row);
  } else {
    std::size_t stride = 0;
    for (const PlyProperty& property : element.properties) stride += size_of(property.type);
    if (stride > 0) take(element, element.count, stride);
  }
}

void PlyReader::next_line(const PlyElement& element) {
  if (!lines_.next_filled()) fail_at_end(element, lines_.offset());
}

const char* PlyReader::take(const PlyElement& element, std::uint64_t count, std::size_t size) {
  if (count > (file_.bytes().size() - offset_) / size) fail_at_end(element, offset_);
  const char* first = file_.bytes().data() + offset_;
  offset_ += count * size;
  return first;
}

void PlyReader::fail_at_end(const PlyElement& element, std::size_t offset) const {
  const std::string name = in_quotes(element.name);
  file_.fail_at_byte(offset, "the file ends inside the data of element " + name + "; copy it again");
}

}  // namespace evermap
