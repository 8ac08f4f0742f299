#include "formats/slice_file.h"
#include "formats/slice_kind.h"
#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>

namespace slim {
namespace {

constexpr std::size_t kPiecePoints = 4096;  // at most: 120 KB, which caches hold
// so many a piece, the last one apart: what is known of a piece takes memory
constexpr std::size_t kLeastPoints = 512;
constexpr std::size_t kBatch = 8;           // pieces that are made while others are written

/// The points of a block in equal pieces, as few as hold them: the pieces first, first + 1, ..., at
/// most `most` of them.
std::vector<EncodedPiece> encode_pieces(const PointBlock& block, std::size_t first,
                                        std::size_t most) {
    const std::size_t n_pieces = (block.size() + kPiecePoints - 1) / kPiecePoints;
    std::vector<EncodedPiece> out(std::min(most, n_pieces - std::min(first, n_pieces)));
    parallel_blocks(out.size(), 1, [&](std::size_t i, std::size_t) {
        const auto begin_of = [&](std::size_t piece) { return block.size() * piece / n_pieces; };
        out[i] = encode_piece(block, begin_of(first + i), begin_of(first + i + 1));
    });
    return out;
}

template <class T>
void append_all(const std::vector<T>& from, std::vector<T>& to) {
    to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

SliceWriter::SliceWriter(const std::string& path, const Vec3d& origin, std::uint64_t n_points,
                         bool has_normals, bool has_scans)
    : chunks_(path, kSliceKind),
      n_announced_(n_points),
      has_normals_(has_normals),
      has_scans_(has_scans) {
    chunks_.add("origin", std::span<const Vec3d>(&origin, 1));
    const SliceColumns columns{has_normals, has_scans};
    chunks_.add("columns", std::span<const SliceColumns>(&columns, 1));
    points_ = chunks_.open("points", 1);
}

void SliceWriter::append(const PointBlock& block) {
    const std::size_t n = block.size();
    SLIM_CHECK(block.id.size(), ==, n);
    SLIM_CHECK(block.normal.size(), ==, has_normals_ ? n : 0);
    SLIM_CHECK(block.scan.size(), ==, has_scans_ ? n : 0);
    if (waiting_.empty() && n >= kLeastPoints) return write(block);
    append_all(block.position, waiting_.position);
    append_all(block.normal, waiting_.normal);
    append_all(block.id, waiting_.id);
    append_all(block.scan, waiting_.scan);
    if (waiting_.size() < kLeastPoints) return;
    write(waiting_);
    waiting_ = {};
}

void SliceWriter::write(const PointBlock& block) {
    std::vector<EncodedPiece> made = encode_pieces(block, 0, kBatch), next;
    for (std::size_t first = 0; !made.empty(); first += kBatch, made = std::move(next)) {
        const auto write_made = [&] {
            for (EncodedPiece& encoded : made) {
                encoded.piece.first_byte = n_bytes_;
                chunks_.append(points_, encoded.bytes.data(), encoded.bytes.size());
                n_bytes_ += encoded.bytes.size();
                n_written_ += encoded.piece.n_points;
                pieces_.push_back(encoded.piece);
            }
        };
        if (made.size() < kBatch) return write_made();
        // The file system takes one writer at a time.
        run_both(write_made, [&] { next = encode_pieces(block, first + kBatch, kBatch); });
    }
}

void SliceWriter::commit() {
    if (!waiting_.empty()) write(waiting_);
    SLIM_CHECK(n_written_, ==, n_announced_);
    chunks_.add("pieces", std::span<const SlicePiece>(pieces_));
    chunks_.commit(Outlasts::process);
}

void write_slice(const std::string& path, const PointBlock& block) {
    SliceWriter writer(path, block.origin, block.size(), block.has_normals(), block.has_scans());
    writer.append(block);
    writer.commit();
}

}  // namespace slim
