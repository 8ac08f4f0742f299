#include "formats/row_encoder.h"

#include "formats/ply_rows.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

namespace slim {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr int kMostDecimals = 20;

template <class T>
void put_binary(T value, bool swap, std::string& out) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (swap) std::reverse(bytes, bytes + sizeof(T));
    out.append(bytes, sizeof(T));
}

template <class T>
void put_shortest(T value, std::string& out) {
    char text[64];
    out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

/// Decimals of a number in text without an exponent; 0 with one.
int decimals_of(std::string_view word) {
    const auto point = word.find('.');
    if (point == std::string_view::npos || word.find_first_of("eE") != std::string_view::npos)
        return 0;
    return static_cast<int>(std::min<std::size_t>(word.size() - point - 1, kMostDecimals));
}

/// Whether a word has more digits than a float keeps, as georeferenced coordinates declared `float`
/// in text have.
bool has_more_than_float(std::string_view word) {
    constexpr auto kDigits = std::numeric_limits<float>::digits10;
    return std::count_if(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; }) >
           kDigits;
}

void put_decimals(double value, int decimals, std::string& out) {
    char text[400];
    if (decimals > kMostDecimals || std::abs(value) > 1e20) return put_shortest(value, out);
    out.append(
        text,
        std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals).ptr);
}

bool is_position(Quantity what) { return what <= Quantity::z; }

}  // namespace

std::string_view RawRows::row(std::size_t i) const {
    if (row_end.empty()) return bytes.substr(i * fixed_size, fixed_size);
    const std::size_t begin = i == 0 ? 0 : row_end[i - 1];
    return bytes.substr(begin, row_end[i] - begin);
}

const RawRows::Slot* RawRows::slots_of(std::size_t i, std::size_t n_columns) const {
    return slots.data() + (row_end.empty() ? 0 : i * n_columns);
}

RowEncoder::RowEncoder(PlyEncoding encoding, std::vector<RowColumn> columns, const Vec3d& origin,
                       double text_step)
    : encoding_(encoding), columns_(std::move(columns)), origin_(origin) {
    while (n_read_ < columns_.size() && columns_[n_read_].in_type) ++n_read_;
    decimals_ = text_step > 0 ? std::max(0, static_cast<int>(std::ceil(-std::log10(text_step))))
                              : kMostDecimals + 1;
}

std::vector<std::string> RowEncoder::encode(const RawRows& rows,
                                            std::span<const RewrittenPoint> points) const {
    std::vector<std::string> pieces((points.size() + kGrain - 1) / kGrain);
    parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::string& out = pieces[begin / kGrain];
        out.reserve((end - begin) * (rows.row(begin).size() + 32));
        for (std::size_t i = begin; i < end; ++i)
            put_row(rows.row(i), rows.slots_of(i, n_read_), points[i], out);
    });
    return pieces;
}

void RowEncoder::put_row(std::string_view row, const RawRows::Slot* slots,
                         const RewrittenPoint& point, std::string& out) const {
    std::size_t copied = 0;
    for (std::size_t c = 0; c < n_read_; ++c) {
        out += row.substr(copied, slots[c].begin - copied);
        put_column(columns_[c], row.substr(slots[c].begin, slots[c].end - slots[c].begin), point,
                   out);
        copied = slots[c].end;
    }
    out += row.substr(copied);
    const bool ascii = encoding_ == PlyEncoding::ascii;
    for (std::size_t c = n_read_; c < columns_.size(); ++c) {
        if (ascii) out += ' ';
        put_number(columns_[c], value(columns_[c], point), {}, out);
    }
    if (ascii) out += '\n';
}

void RowEncoder::put_column(const RowColumn& column, std::string_view old,
                            const RewrittenPoint& point, std::string& out) const {
    const bool keeps = !point.moved && column.what != Quantity::displacement;
    if (!keeps) put_number(column, value(column, point), old, out);
    else if (encoding_ == PlyEncoding::ascii || column.type == *column.in_type) out += old;
    else put_number(column, load_ply_number(old.data(), *column.in_type, encoding_), old, out);
}

double RowEncoder::value(const RowColumn& column, const RewrittenPoint& point) const {
    if (column.what == Quantity::displacement) return point.displacement;
    const auto axis = static_cast<std::size_t>(column.what) % 3;
    return is_position(column.what) ? point.position[axis] - origin_[axis] : point.normal[axis];
}

void RowEncoder::put_number(const RowColumn& column, double value, std::string_view old,
                            std::string& out) const {
    const bool swap = encoding_ == PlyEncoding::big_endian;
    if (encoding_ != PlyEncoding::ascii && column.type == PlyType::f64)
        put_binary(value, swap, out);
    else if (encoding_ != PlyEncoding::ascii) put_binary(static_cast<float>(value), swap, out);
    else if (is_position(column.what) && (column.type == PlyType::f64 || has_more_than_float(old)))
        put_decimals(value, std::max(decimals_, decimals_of(old)), out);
    else put_shortest(static_cast<float>(value), out);
}

}  // namespace slim
