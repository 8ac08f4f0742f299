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

std::size_t pieces_for(std::size_t n_points) {
    return (n_points + kPiecePoints - 1) / kPiecePoints;
}

/// Where in a block each of the equal pieces begins that its chosen points make, as few as hold
/// them, and where the last one ends.
std::vector<std::size_t> piece_begins(const std::vector<bool>& chosen, std::size_t n_chosen) {
    const std::size_t n_pieces = pieces_for(n_chosen);
    std::vector<std::size_t> begins;
    std::size_t next = 0;  // of the chosen ones, the first of a piece
    for (std::size_t i = 0, n = 0; i < chosen.size(); ++i) {
        if (!chosen[i]) continue;
        if (n++ < next) continue;
        begins.push_back(i);
        next = n_chosen * begins.size() / n_pieces;
    }
    begins.push_back(chosen.size());
    return begins;
}

/// The n chosen ones of the points [begin, end).
PointBlock chosen_of(const PointBlock& block, const std::vector<bool>& chosen, std::size_t begin,
                     std::size_t end, std::size_t n) {
    PointBlock out;
    const auto copy = [&](const auto& values, auto& to) {
        if (values.empty()) return;
        to.reserve(n);
        for (std::size_t i = begin; i < end; ++i)
            if (chosen[i]) to.push_back(values[i]);
    };
    copy(block.position, out.position);
    copy(block.normal, out.normal);
    copy(block.id, out.id);
    copy(block.scan, out.scan);
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

void SliceWriter::check_columns(const PointBlock& block) const {
    const std::size_t n = block.size();
    SLIM_CHECK(block.id.size(), ==, n);
    SLIM_CHECK(block.normal.size(), ==, has_normals_ ? n : 0);
    SLIM_CHECK(block.scan.size(), ==, has_scans_ ? n : 0);
}

void SliceWriter::append(const PointBlock& block, Apart apart) {
    check_columns(block);
    const std::size_t n = block.size();
    PointBlock& waiting = waiting_[apart == Apart::yes ? 1 : 0];
    if (waiting.empty() && n >= kLeastPoints) return write(block);
    append_all(block.position, waiting.position);
    append_all(block.normal, waiting.normal);
    append_all(block.id, waiting.id);
    append_all(block.scan, waiting.scan);
    if (waiting.size() < kLeastPoints) return;
    write(waiting);
    waiting = {};
}

void SliceWriter::append(const PointBlock& block, const std::vector<bool>& chosen) {
    check_columns(block);
    SLIM_CHECK(chosen.size(), ==, block.size());
    const auto n = static_cast<std::size_t>(std::count(chosen.begin(), chosen.end(), true));
    if (n < kLeastPoints || !waiting_[0].empty())
        return append(chosen_of(block, chosen, 0, block.size(), n));
    const std::vector<std::size_t> begins = piece_begins(chosen, n);
    const std::size_t n_pieces = begins.size() - 1;
    write_pieces(n_pieces, [&](std::size_t i) {
        const std::size_t n_here = n * (i + 1) / n_pieces - n * i / n_pieces;
        if (n_here == begins[i + 1] - begins[i])
            return encode_piece(block, begins[i], begins[i + 1]);
        const PointBlock piece = chosen_of(block, chosen, begins[i], begins[i + 1], n_here);
        return encode_piece(piece, 0, piece.size());
    });
}

/// In equal pieces, as few as hold them.
void SliceWriter::write(const PointBlock& block) {
    const std::size_t n_pieces = pieces_for(block.size());
    const auto begin_of = [&](std::size_t piece) { return block.size() * piece / n_pieces; };
    write_pieces(n_pieces, [&](std::size_t i) {
        return encode_piece(block, begin_of(i), begin_of(i + 1));
    });
}

void SliceWriter::write_pieces(std::size_t n_pieces,
                               const std::function<EncodedPiece(std::size_t)>& encode) {
    const auto encode_from = [&](std::size_t first) {
        std::vector<EncodedPiece> out(std::min(kBatch, n_pieces - std::min(first, n_pieces)));
        parallel_blocks(out.size(), 1,
                        [&](std::size_t i, std::size_t) { out[i] = encode(first + i); });
        return out;
    };
    std::vector<EncodedPiece> made = encode_from(0), next;
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
        run_both(write_made, [&] { next = encode_from(first + kBatch); });
    }
}

void SliceWriter::commit() {
    for (const PointBlock& waiting : waiting_)
        if (!waiting.empty()) write(waiting);
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
