#include "formats/ply_rows.h"

#include "formats/message.h"
#include "formats/number_text.h"
#include "formats/ply_number.h"
#include "slim/base/error.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace slim {

static_assert(std::endian::native == std::endian::little);

double load_ply_number(const char* bytes, PlyType type, PlyEncoding encoding) {
    const bool swap = encoding == PlyEncoding::big_endian;
    double value = 0;
    with_ply_type(type, [&]<class T>(T) {
        value = static_cast<double>(load_number<T>(bytes, swap));
    });
    return value;
}

PlyRows::PlyRows(ByteReader& in, const PlyHeader& header, const PlyElement& element,
                 int wanted_list)
    : in_(in),
      element_(element),
      encoding_(header.encoding),
      wanted_list_(wanted_list),
      scalars_(element.properties.size()) {}

std::string PlyRows::place() const {
    return encoding_ == PlyEncoding::ascii ? message("line ", in_.line_number())
                                           : message("byte ", row_offset_);
}

void PlyRows::fail(const std::string& text) const {
    throw FormatError(message(in_.path(), ": ", place(), ": row ", n_read_ + 1, " of element ",
                              element_.name, ": ", text));
}

void PlyRows::fail_truncated() const {
    throw FormatError(message(in_.path(), ": byte ", in_.offset(), ": the file ends after ",
                              n_read_, " of the ", element_.count, " rows that element ",
                              element_.name, " declares"));
}

bool PlyRows::next() {
    if (n_read_ == element_.count) return false;
    if (element_.properties.empty()) {
        n_read_ = element_.count;
        return false;
    }
    if (encoding_ == PlyEncoding::ascii) next_ascii();
    else next_binary();
    ++n_read_;
    return true;
}

double PlyRows::ascii_value(std::string_view& line, std::size_t column) {
    const std::string_view word = next_word(line);
    double value = 0;
    if (word.empty())
        fail(message("the row ends where property ", element_.properties[column].name, " (number ",
                     column + 1, " of ", element_.properties.size(), ") was expected"));
    if (!parse_number(word, value))
        fail(message("expected a number for property ", element_.properties[column].name,
                     ", found '", word.substr(0, 40), "'"));
    return value;
}

std::uint64_t PlyRows::list_count(double count, const PlyProperty& property) const {
    if (!(count >= 0 && count < 1e15 && std::floor(count) == count))
        fail(message("list ", property.name, " cannot have ", count, " values"));
    return static_cast<std::uint64_t>(count);
}

void PlyRows::next_ascii() {
    std::string_view line;
    do {
        if (!in_.read_line(line)) fail_truncated();
    } while (line.find_first_not_of(" \t\v\f") == std::string_view::npos);
    const char* const start = line.data();
    if (!ranges_.empty()) raw_ = line;
    for (std::size_t i = 0; i < element_.properties.size(); ++i) {
        const PlyProperty& property = element_.properties[i];
        scalars_[i] = ascii_value(line, i);
        if (!ranges_.empty()) {
            const auto end = static_cast<std::size_t>(line.data() - start);
            const std::size_t blank = raw_.find_last_of(" \t\r\v\f", end - 1);
            ranges_[i] = {blank == std::string::npos ? 0 : blank + 1, end};
        }
        if (!property.is_list) continue;
        const bool wanted = static_cast<int>(i) == wanted_list_;
        if (wanted) list_.clear();
        for (std::uint64_t n = list_count(scalars_[i], property); n > 0; --n) {
            const double value = ascii_value(line, i);
            if (wanted) list_.push_back(value);
        }
    }
    if (const std::string_view more = next_word(line); !more.empty())
        fail(message("more values than the header declares, from '", more.substr(0, 40), "'"));
}

double PlyRows::take(PlyType type) {
    const std::size_t size = size_of(type);
    const std::string_view bytes = in_.peek(size);
    if (bytes.size() < size) fail_truncated();
    const double value = load_ply_number(bytes.data(), type, encoding_);
    if (!ranges_.empty()) raw_ += bytes.substr(0, size);
    in_.advance(size);
    return value;
}

bool PlyRows::pass_over(std::uint64_t n_bytes) {
    if (ranges_.empty()) return in_.skip(n_bytes);
    // a count that lies must not ask for the rest of the file at once
    constexpr std::uint64_t kAtOnce = 1 << 20;
    while (n_bytes > 0) {
        const std::uint64_t wanted = std::min(n_bytes, kAtOnce);
        const std::string_view bytes = in_.peek(wanted).substr(0, wanted);
        raw_ += bytes;
        in_.advance(bytes.size());
        if (bytes.size() < wanted) return false;
        n_bytes -= wanted;
    }
    return true;
}

void PlyRows::next_binary() {
    row_offset_ = in_.offset();
    raw_.clear();
    for (std::size_t i = 0; i < element_.properties.size(); ++i) {
        const PlyProperty& property = element_.properties[i];
        if (!property.is_list) {
            scalars_[i] = take(property.type);
            if (!ranges_.empty()) ranges_[i] = {raw_.size() - size_of(property.type), raw_.size()};
            continue;
        }
        scalars_[i] = take(property.count_type);
        const std::uint64_t n = list_count(scalars_[i], property);
        if (static_cast<int>(i) != wanted_list_) {
            if (!pass_over(n * size_of(property.type))) fail_truncated();
            continue;
        }
        list_.clear();
        for (std::uint64_t k = 0; k < n; ++k) list_.push_back(take(property.type));
    }
}

void PlyRows::skip_all() {
    const auto size = element_.fixed_size();
    if (encoding_ != PlyEncoding::ascii && size) {
        const std::uint64_t rows = element_.count - n_read_;
        if (*size > 0 && (rows > UINT64_MAX / *size || !in_.skip(rows * *size))) fail_truncated();
        n_read_ = element_.count;
        return;
    }
    while (next()) {
    }
}

void check_ply_count(const ByteReader& in, const PlyElement& element, PlyEncoding encoding) {
    const auto left = in.remaining();
    const std::size_t least = element.least_row_size(encoding);
    if (!left || least == 0) return;
    // The last ascii row needs no line end.
    const std::uint64_t fits = (*left + (encoding == PlyEncoding::ascii ? 1 : 0)) / least;
    if (element.count <= fits) return;
    throw FormatError(message(in.path(), ": byte ", in.offset(), ": element ", element.name,
                              " declares ", element.count, " rows of at least ", least,
                              " bytes, but ", *left, " bytes follow: room for ", fits,
                              "; the file is cut off or its header is wrong"));
}

}  // namespace slim
