#pragma once

#include "formats/chunk_file.h"
#include "formats/slice_piece.h"
#include "slim/model/point_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace slim {

/// Writes the points of one slice as they come (points.slice: in order of their ids, but for those
/// near other slices, which come apart; oriented.slice: along the Morton curve) in pieces
/// (slice_piece.h) that are read apart. Holds less than 512 points of either kind, 46 bytes each,
/// that are too few for a piece. How points come decides about pieces, not about what is read.
/// 30 bytes a point where floats hold the positions. Throws as AtomicFile.
class SliceWriter {
public:
    /// Whether points go into pieces that hold none of the others.
    enum class Apart { no, yes };

    SliceWriter(const std::string& path, const Vec3d& origin, std::uint64_t n_points,
                bool has_normals, bool has_scans);
    /// Columns as the constructor announced (a SLIM_CHECK); the origin of the block is not looked
    /// at. Parallel where the block is large; different writers may append at the same time.
    void append(const PointBlock& block, Apart apart = Apart::no);
    /// Appends the chosen points, as if the block held no others.
    void append(const PointBlock& block, const std::vector<bool>& chosen);
    /// All announced points must have come (a SLIM_CHECK).
    void commit();

private:
    void check_columns(const PointBlock& block) const;
    void write(const PointBlock& block);
    /// encode(i) makes the i-th piece, by several threads at once.
    void write_pieces(std::size_t n_pieces,
                      const std::function<EncodedPiece(std::size_t)>& encode);

    ChunkWriter chunks_;
    std::size_t points_;
    std::vector<SlicePiece> pieces_;
    std::array<PointBlock, 2> waiting_;  // too few for a piece by themselves; those apart
    std::uint64_t n_announced_, n_written_ = 0, n_bytes_ = 0;
    bool has_normals_, has_scans_;
};

void write_slice(const std::string& path, const PointBlock& block);

/// Reads a whole slice; every piece is checked. Parallel. Takes no memory but the block's.
/// throws FormatError naming file, place and reason; IoError
PointBlock read_slice(const std::string& path);

/// Whether a file says that it is a slice.
bool is_slice_file(const std::string& path);

/// Tells slices of different contents apart (ChunkFile::identity); reads no points.
/// throws FormatError, IoError
std::string slice_identity(const std::string& path);

/// Whether there is a slice of that identity whose checksums all match.
bool is_whole_slice(const std::string& path, const std::string& identity);

/// What is wanted of the points within a box.
enum class WantedOf { none, some, all };

/// Chosen points of several slices, read into a block that is as large as they are. Parallel. All
/// throw as read_slice.
class SliceSelection {
public:
    SliceSelection();
    ~SliceSelection();

    /// Adds the points of a slice whose positions are wanted. Pieces of which none are wanted by
    /// their box are not read, nor checked. is_wanted  asked where a box says `some`
    void add(const std::string& path, const std::function<WantedOf(const Bbox&)>& wanted_of,
             const std::function<bool(const Vec3d&)>& is_wanted);
    /// The same for all points.
    void add(const std::string& path);
    /// The same for the points whose id is wanted.
    void add(const std::string& path, const std::function<bool(std::uint64_t id)>& is_wanted);
    /// Appends them to `out`, slice after slice, each in its order. An empty block takes over the
    /// slices' origin and columns. throws FormatError if columns or origin are others than those of
    /// `out`, or of each other
    void append_to(PointBlock& out) const;

private:
    struct Part;
    std::vector<std::unique_ptr<Part>> parts_;
};

}  // namespace slim
