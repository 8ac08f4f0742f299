#include "formats/xyz_reader.h"

#include "formats/message.h"
#include "formats/number_text.h"
#include "slim/base/error.h"

#include <algorithm>
#include <charconv>

namespace slim {
namespace {

constexpr std::size_t kRowsToLookAt = 100;

bool is_comment(std::string_view word) { return word.starts_with("#") || word.starts_with("//"); }

}  // namespace

XyzReader::XyzReader(const std::string& path) : in_(path) {
    in_.skip_byte_order_mark();
    look_ahead();
    describe();
}

void XyzReader::fail(const std::string& text) const {
    throw FormatError(message(in_.path(), ": line ", in_.line_number(), ": ", text));
}

/// A PTS count: one whole number alone on its line, where a block of points begins.
bool XyzReader::take_count() {
    if (words_.size() != 1) return false;
    std::uint64_t count = 0;
    const char* end = words_[0].data() + words_[0].size();
    const auto [stop, status] = std::from_chars(words_[0].data(), end, count);
    if (status != std::errc{} || stop != end) return false;
    if (last_was_count_) fail("two counts in a row; this looks like PTX, which is not read");
    if (n_rows_ < declared_.value_or(0))
        fail(message("a count after ", n_rows_, " points, but ", declared_.value_or(0),
                     " were declared before it"));
    if (count > UINT64_MAX / 2 - declared_.value_or(0)) fail("a count beyond reason");
    declared_ = declared_.value_or(0) + count;
    last_was_count_ = true;
    return true;
}

/// Reads the next point's numbers to row_; false at the end of the file.
bool XyzReader::next_row() {
    std::string_view line;
    while (in_.read_line(line)) {
        split_row(line, words_);
        if (words_.empty()) continue;
        const bool before_rows = n_rows_ == 0 && !last_was_count_;
        if (is_comment(words_[0])) {
            if (before_rows) named_ = columns_from_names(line, columns_) || named_;
            continue;
        }
        if (take_count()) continue;
        double first = 0;
        if (before_rows && !parse_number(words_[0], first) && columns_from_names(line, columns_)) {
            named_ = true;
            continue;
        }
        // Only the first rows: a later one has as many columns as they, or is refused for that.
        if (n_rows_ < kRowsToLookAt && has_decimal_commas(line))
            fail(message("numbers with decimal commas ('", line.substr(0, 40),
                         "'): expected decimal points; convert with: sed 's/,/./g' ", in_.path(),
                         " > points.xyz"));
        if (before_rows && std::none_of(words_.begin(), words_.end(), [&](std::string_view word) {
                return parse_number(word, first);
            }))
            fail(message("expected numbers, or a line of names with x, y and z (nx ny nz: normals; "
                         "scan: its number; any case), found '", line.substr(0, 60), "'"));
        row_.resize(words_.size());
        for (std::size_t i = 0; i < words_.size(); ++i)
            if (!parse_number(words_[i], row_[i]))
                fail(message("column ", i + 1, ": expected a number, found '",
                             words_[i].substr(0, 40), "'"));
        ++n_rows_;
        last_was_count_ = false;
        // More points than declared lose nothing; PTS files in the wild have miscounted.
        if (declared_ && n_rows_ > *declared_) ++info_.n_undeclared;
        return true;
    }
    if (declared_ && n_rows_ < *declared_)
        fail(message("the file ends after ", n_rows_, " of ", *declared_, " declared points"));
    return false;
}

void XyzReader::look_ahead() {
    while (ahead_.size() < kRowsToLookAt && next_row()) {
        if (row_.size() < 3)
            fail(message("expected at least 3 columns (x y z), found ", row_.size()));
        if (!ahead_.empty() && row_.size() != ahead_[0].size())
            fail(message("expected ", ahead_[0].size(), " columns, found ", row_.size()));
        ahead_.push_back(row_);
    }
    if (ahead_.empty()) return;
    // A comment that happens to hold the letters is no header: it must name every column.
    if (!named_ || columns_.n_columns != ahead_[0].size()) columns_ = columns_from_rows(ahead_);
}

void XyzReader::describe() {
    info_.path = in_.path();
    info_.format = in_.is_gzip() ? "XYZ text gzip" : "XYZ text";
    info_.n_points = declared_;
    info_.has_normals = columns_.has_normals();
    info_.has_scan = columns_.scan >= 0;
    info_.coordinates = CoordinateType::text;
    info_.file_size = in_.file_size();
    info_.carried = {"x", "y", "z"};
    if (info_.has_normals) info_.carried.insert(info_.carried.end(), {"nx", "ny", "nz"});
    if (info_.has_scan) info_.carried.emplace_back("scan");
    if (columns_.names.empty()) {
        for (std::size_t i = info_.carried.size(); i < columns_.n_columns; ++i)
            info_.skipped.push_back(message("unnamed ", i - info_.carried.size() + 1));
        return;
    }
    for (int i = 0; i < static_cast<int>(columns_.n_columns); ++i)
        if (!columns_.carries(i))
            info_.skipped.push_back(columns_.names[static_cast<std::size_t>(i)]);
}

void XyzReader::store(const std::vector<double>& row, PointChunk& out) const {
    const auto at = [&](int column) { return row[static_cast<std::size_t>(column)]; };
    const auto& p = columns_.position;
    out.position.push_back({at(p[0]), at(p[1]), at(p[2])});
    const auto& n = columns_.normal;
    if (info_.has_normals) out.normal.push_back(to_float(Vec3d{at(n[0]), at(n[1]), at(n[2])}));
    if (!info_.has_scan) return;
    const double scan = at(columns_.scan);
    if (!(scan >= 0 && scan <= 65535)) fail(message("scan ", scan, " is outside 0 to 65535"));
    out.scan.push_back(static_cast<std::uint16_t>(scan));
}

bool XyzReader::read(PointChunk& out, std::size_t max_points) {
    out.resize(0, info_);
    while (out.size() < max_points && n_ahead_given_ < ahead_.size())
        store(ahead_[n_ahead_given_++], out);
    while (out.size() < max_points && next_row()) {
        if (row_.size() != columns_.n_columns)
            fail(message("expected ", columns_.n_columns, " columns, found ", row_.size()));
        store(row_, out);
    }
    return out.size() > 0;
}

}  // namespace slim
