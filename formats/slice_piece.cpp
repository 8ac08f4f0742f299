#include "formats/slice_piece.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace slim {
namespace {

constexpr std::uint64_t kAlignment = 8;

bool is_float(double value) { return static_cast<double>(static_cast<float>(value)) == value; }

/// Bytes of a piece, column after column.
class Bytes {
public:
    explicit Bytes(std::size_t n) : bytes_(n) {}

    template <class T>
    void put_all(const T* values, std::size_t n) {
        std::memcpy(bytes_.data() + n_, values, n * sizeof(T));
        n_ += n * sizeof(T);
    }
    /// make(i) for i in [0, n)
    template <class Make>
    void put_each(std::size_t n, const Make& make) {
        unsigned char* to = bytes_.data() + n_;
        for (std::size_t i = 0; i < n; ++i) {
            const auto value = make(i);
            std::memcpy(to + i * sizeof(value), &value, sizeof(value));
        }
        n_ += n * sizeof(make(0));
    }
    std::vector<unsigned char> take() { return std::move(bytes_); }

private:
    std::vector<unsigned char> bytes_;
    std::size_t n_ = 0;
};

template <class T>
T value_at(const unsigned char* column, std::size_t i) {
    T value;
    std::memcpy(&value, column + i * sizeof(T), sizeof(T));
    return value;
}

/// Copies a column's chosen values, all if `chosen` is empty, converted each, to `to` and on.
template <class T, class Out, class Convert>
void copy_column(const unsigned char* column, std::size_t n, const std::vector<bool>& chosen,
                 Out* to, const Convert& convert) {
    if (chosen.empty()) {
        for (std::size_t i = 0; i < n; ++i) to[i] = convert(value_at<T>(column, i));
        return;
    }
    for (std::size_t i = 0; i < n; ++i)
        if (chosen[i]) *to++ = convert(value_at<T>(column, i));
}

/// The same of a few values, by their number.
template <class T, class Out, class Convert>
void copy_column(const unsigned char* column, std::size_t, std::span<const std::uint32_t> chosen,
                 Out* to, const Convert& convert) {
    for (const std::uint32_t i : chosen) *to++ = convert(value_at<T>(column, i));
}

}  // namespace

std::uint64_t SlicePiece::n_bytes(bool has_normals, bool has_scans) const {
    const std::uint64_t a_point = std::uint64_t{3} * coordinate_bytes + id_bytes +
                                  (has_normals ? sizeof(Vec3f) : 0) +
                                  (has_scans ? sizeof(std::uint16_t) : 0);
    return (n_points * a_point + kAlignment - 1) / kAlignment * kAlignment;
}

EncodedPiece encode_piece(const PointBlock& block, std::size_t begin, std::size_t end) {
    EncodedPiece out{};
    SlicePiece& piece = out.piece;
    piece.box = {};
    piece.n_points = static_cast<std::uint32_t>(end - begin);
    bool are_floats = true;
    for (std::size_t i = begin; i < end; ++i) {
        const Vec3d& p = block.position[i];
        piece.box.extend(p);
        are_floats &= is_float(p.x) & is_float(p.y) & is_float(p.z);
    }
    const auto id_at = [&](std::size_t i) {
        return block.id.begin() + static_cast<std::ptrdiff_t>(i);
    };
    const auto [least, most] = std::minmax_element(id_at(begin), id_at(end));
    piece.least_id = *least;
    piece.coordinate_bytes = are_floats ? sizeof(float) : sizeof(double);
    piece.id_bytes = *most - *least <= std::numeric_limits<std::uint32_t>::max() ? 4 : 8;
    Bytes bytes(piece.n_bytes(block.has_normals(), block.has_scans()));
    const std::size_t n = end - begin;
    if (are_floats)
        bytes.put_each(n, [&](std::size_t i) { return to_float(block.position[begin + i]); });
    else
        bytes.put_all(&block.position[begin], n);
    const auto id_over_least = [&](std::size_t i) { return block.id[begin + i] - piece.least_id; };
    if (piece.id_bytes == 4)
        bytes.put_each(
            n, [&](std::size_t i) { return static_cast<std::uint32_t>(id_over_least(i)); });
    else
        bytes.put_each(n, id_over_least);
    if (block.has_normals()) bytes.put_all(&block.normal[begin], end - begin);
    if (block.has_scans()) bytes.put_all(&block.scan[begin], end - begin);
    out.bytes = bytes.take();
    piece.checksum = XXH3_64bits(out.bytes.data(), out.bytes.size());
    return out;
}

PieceColumns::PieceColumns(const SlicePiece& piece, std::span<const unsigned char> bytes,
                           bool has_normals, bool has_scans)
    : piece_(piece), positions_(bytes.data()) {
    const std::size_t n = piece.n_points;
    ids_ = positions_ + 3 * n * piece.coordinate_bytes;
    const unsigned char* const after_ids = ids_ + n * piece.id_bytes;
    if (has_normals) normals_ = after_ids;
    if (has_scans) scans_ = after_ids + (has_normals ? n * sizeof(Vec3f) : 0);
}

Vec3d PieceColumns::position(std::size_t i) const {
    return piece_.coordinate_bytes == sizeof(float) ? to_double(value_at<Vec3f>(positions_, i))
                                                    : value_at<Vec3d>(positions_, i);
}

std::uint64_t PieceColumns::id(std::size_t i) const {
    return piece_.least_id + (piece_.id_bytes == 4 ? value_at<std::uint32_t>(ids_, i)
                                                   : value_at<std::uint64_t>(ids_, i));
}

template <class Chosen>
void PieceColumns::copy_chosen(const Chosen& chosen, PointBlock& out, std::size_t at) const {
    const auto copy = [&]<class T>(T, const unsigned char* column, auto& to, const auto& convert) {
        if (column) copy_column<T>(column, piece_.n_points, chosen, to.data() + at, convert);
    };
    const auto as_it_is = [](const auto& value) { return value; };
    const auto over_least = [this](std::uint64_t id) { return piece_.least_id + id; };
    if (piece_.coordinate_bytes == sizeof(float))
        copy(Vec3f{}, positions_, out.position, [](const Vec3f& p) { return to_double(p); });
    else
        copy(Vec3d{}, positions_, out.position, as_it_is);
    if (piece_.id_bytes == sizeof(std::uint32_t))
        copy(std::uint32_t{}, ids_, out.id, over_least);
    else
        copy(std::uint64_t{}, ids_, out.id, over_least);
    copy(Vec3f{}, normals_, out.normal, as_it_is);
    copy(std::uint16_t{}, scans_, out.scan, as_it_is);
}

void PieceColumns::copy_to(const std::vector<bool>& chosen, PointBlock& out, std::size_t at) const {
    copy_chosen(chosen, out, at);
}

void PieceColumns::copy_to(std::span<const std::uint32_t> chosen, PointBlock& out,
                           std::size_t at) const {
    copy_chosen(chosen, out, at);
}

}  // namespace slim
