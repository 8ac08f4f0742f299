#pragma once

#include "slim/base/bbox.h"
#include "slim/model/point_block.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// A run of a slice's points in its file: where it lies, what is in it. Its bytes: positions, ids
/// (over the least one), normals, scans, each of all its points, then zeros up to a multiple of 8.
struct SlicePiece {
    Bbox box;                    ///< of its positions
    std::uint64_t first_byte;    ///< in the chunk of points
    std::uint64_t checksum;      ///< XXH3-64 of its bytes
    std::uint64_t least_id;
    std::uint32_t n_points;
    std::uint16_t
        coordinate_bytes;  ///< 4 where floats give all its positions to the last bit, else 8
    std::uint16_t id_bytes;          ///< 4 or 8

    std::uint64_t n_bytes(bool has_normals, bool has_scans) const;
};
static_assert(sizeof(SlicePiece) == 80);

/// A piece and its bytes; first_byte is left to who writes them.
struct EncodedPiece {
    SlicePiece piece;
    std::vector<unsigned char> bytes;
};

/// The points [begin, end) of a block, at least one, in as few bytes as hold them exactly.
EncodedPiece encode_piece(const PointBlock& block, std::size_t begin, std::size_t end);

/// The columns of one piece, as they lie in its bytes, which must outlive it.
class PieceColumns {
public:
    /// bytes: as many as piece.n_bytes()
    PieceColumns(const SlicePiece& piece, std::span<const unsigned char> bytes, bool has_normals,
                 bool has_scans);

    Vec3d position(std::size_t i) const;
    std::uint64_t id(std::size_t i) const;
    /// Writes the chosen points, all if `chosen` is empty, to places at, at + 1, ... of a block
    /// that has room for them.
    void copy_to(const std::vector<bool>& chosen, PointBlock& out, std::size_t at) const;
    /// The same of a few points by their number in the piece, none of none.
    void copy_to(std::span<const std::uint32_t> chosen, PointBlock& out, std::size_t at) const;

private:
    template <class Chosen>
    void copy_chosen(const Chosen& chosen, PointBlock& out, std::size_t at) const;

    const SlicePiece& piece_;
    const unsigned char *positions_, *ids_, *normals_ = nullptr, *scans_ = nullptr;
};

}  // namespace slim
