#pragma once

#include "formats/byte_reader.h"
#include "formats/point_source.h"
#include "formats/xyz_columns.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// A text of coordinates, one point a line, separated by blanks, commas or semicolons. Lines that
/// are empty or start with `#` or `//` are passed over; a line of names may come first; a line with
/// one whole number alone (PTS) says how many points follow. UTF-8's byte order mark may stand
/// before all of it.
/// throws FormatError naming the line: a word that is no number, another number of columns than the
///        first row, fewer points than a PTS count said
class XyzReader : public PointSource {
public:
    explicit XyzReader(const std::string& path);
    bool read(PointChunk& out, std::size_t max_points) override;
    std::uint64_t bytes_read() const override { return in_.file_bytes_read(); }
    const XyzColumns& columns() const { return columns_; }

private:
    bool next_row();
    bool take_count();
    void look_ahead();
    void store(const std::vector<double>& row, PointChunk& out) const;
    void describe();
    [[noreturn]] void fail(const std::string& text) const;

    ByteReader in_;
    XyzColumns columns_;
    std::optional<std::uint64_t> declared_;  ///< by the PTS counts so far
    std::uint64_t n_rows_ = 0;
    bool last_was_count_ = false;
    bool named_ = false;
    std::vector<std::string_view> words_;
    std::vector<double> row_;
    std::vector<std::vector<double>> ahead_;  ///< rows that were read to tell the columns
    std::size_t n_ahead_given_ = 0;
};

}  // namespace slim
