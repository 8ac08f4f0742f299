#include "formats/xyz_rewriter.h"

#include "formats/message.h"
#include "formats/number_text.h"
#include "formats/xyz_reader.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <algorithm>

namespace slim {

XyzRewriter::XyzRewriter(const std::string& in, const std::string& out, double text_step)
    : in_(in), out_(out), columns_(XyzReader(in).columns()) {
    std::vector<std::pair<int, RowColumn>> found;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = [&](Quantity first) {
            return static_cast<Quantity>(static_cast<std::size_t>(first) + axis);
        };
        found.push_back({columns_.position[axis], {at(Quantity::x), PlyType::f64, PlyType::f64}});
        if (columns_.has_normals())
            found.push_back(
                {columns_.normal[axis], {at(Quantity::nx), PlyType::f32, PlyType::f32}});
    }
    std::sort(found.begin(), found.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<RowColumn> columns;
    for (const auto& [number, column] : found) {
        numbers_.push_back(static_cast<std::size_t>(number));
        columns.push_back(column);
    }
    encoder_ = std::make_unique<RowEncoder>(PlyEncoding::ascii, columns, Vec3d{}, text_step);
    if (in_.skip_byte_order_mark()) out_.write(kByteOrderMark);
}

bool XyzRewriter::next_line() {
    if (!in_.read_line(line_)) return false;
    split_row(line_, words_);
    return true;
}

/// The reader has seen every line before: one of as many columns, the first a number, is a point's.
bool XyzRewriter::is_point() const {
    double first = 0;
    return words_.size() == columns_.n_columns && parse_number(words_[0], first);
}

void XyzRewriter::write(std::span<const RewrittenPoint> points) {
    RawRows rows;
    std::string bytes;
    while (rows.row_end.size() < points.size()) {
        if (!next_line())
            throw FormatError(message(in_.path(), ": line ", in_.line_number(),
                                      ": the file has become shorter while it was read"));
        const std::size_t begin = rows.row_end.empty() ? 0 : rows.row_end.back();
        const std::size_t shift = bytes.size() - begin;  // other lines stand before the point's
        bytes += line_;
        if (!is_point()) {
            bytes += '\n';
            continue;
        }
        for (const std::size_t number : numbers_) {
            const auto at = shift + static_cast<std::size_t>(words_[number].data() - line_.data());
            rows.slots.push_back({at, at + words_[number].size()});
        }
        rows.row_end.push_back(bytes.size());
    }
    rows.bytes = bytes;
    for (const std::string& piece : encoder_->encode(rows, points)) out_.write(piece);
}

void XyzRewriter::commit() {
    while (next_line()) {
        SLIM_CHECK(is_point(), ==, false);
        out_.write(line_);
        out_.write("\n");
    }
    out_.commit();
}

}  // namespace slim
