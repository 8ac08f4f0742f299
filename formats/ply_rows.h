#pragma once

#include "formats/byte_reader.h"
#include "formats/ply_header.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// A little- or big-endian number at `bytes` as a double.
double load_ply_number(const char* bytes, PlyType type, PlyEncoding encoding);

/// Walks the rows of one element, of any types, lists and encoding, from where the reader stands.
/// next() gives the scalars of a row, and of its lists the one that was asked for.
///
/// throws FormatError: the file ends early, an ascii row has too few or too many values or a word
///        that is no number, a list has a negative count
class PlyRows {
public:
    /// wanted_list: index of the list property to keep, or -1.
    PlyRows(ByteReader& in, const PlyHeader& header, const PlyElement& element,
            int wanted_list = -1);

    /// Decodes the next row; false after the last.
    bool next();
    /// Keeps each row from now on as it stands in the file;
    /// to be asked for before the first next().
    void keep_raw() { ranges_.resize(element_.properties.size()); }
    /// The last row as it stands in the file, an ascii one without its line end.
    const std::string& raw() const { return raw_; }
    /// Where in raw() a scalar stands.
    struct Range {
        std::size_t begin = 0, end = 0;
    };
    Range range(std::size_t property) const { return ranges_[property]; }
    /// Passes over all rows that are left.
    void skip_all();
    /// By index of the property; a list's entry is its count.
    const std::vector<double>& scalars() const { return scalars_; }
    const std::vector<double>& list() const { return list_; }
    std::uint64_t n_read() const { return n_read_; }
    /// "line 12" or "byte 345": where the last row was.
    std::string place() const;

private:
    void next_ascii();
    void next_binary();
    double take(PlyType type);
    bool pass_over(std::uint64_t n_bytes);
    double ascii_value(std::string_view& line, std::size_t column);
    std::uint64_t list_count(double count, const PlyProperty& property) const;
    [[noreturn]] void fail(const std::string& text) const;
    [[noreturn]] void fail_truncated() const;

    ByteReader& in_;
    const PlyElement& element_;
    PlyEncoding encoding_;
    int wanted_list_;
    std::uint64_t n_read_ = 0;
    std::uint64_t row_offset_ = 0;
    std::vector<double> scalars_;
    std::vector<double> list_;
    std::string raw_;            // if kept
    std::vector<Range> ranges_;  // empty: not kept
};

/// Refuses a count that the rest of the file cannot hold, before anything is allocated for it. A
/// gzip file's length is unknown: there a reader must grow with what it has read.
void check_ply_count(const ByteReader& in, const PlyElement& element, PlyEncoding encoding);

}  // namespace slim
