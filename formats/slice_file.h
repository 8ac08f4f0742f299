#pragma once

#include "formats/chunk_file.h"
#include "slim/model/point_block.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace slim {

/// Writes the points of one slice as they come (points.slice: in order of their ids,
/// oriented.slice: along the Morton curve) without holding them: their number is known from the
/// first pass. Throws as AtomicFile.
class SliceWriter {
public:
    SliceWriter(const std::string& path, const Vec3d& origin, std::uint64_t n_points,
                bool has_normals, bool has_scans);
    /// Columns as the constructor announced (a SLIM_CHECK); the origin of the block is not looked
    /// at.
    void append(const PointBlock& block);
    /// All announced points must have come (a SLIM_CHECK).
    void commit() { chunks_.commit(Outlasts::process); }

private:
    ChunkWriter chunks_;
    std::size_t position_, id_, normal_, scan_;
    bool has_normals_, has_scans_;
};

void write_slice(const std::string& path, const PointBlock& block);

/// Reads a whole slice; every chunk is checked. Takes no memory but the block's.
/// throws FormatError naming file, place and reason; IoError
PointBlock read_slice(const std::string& path);

/// Appends the points of a slice whose positions are wanted to `out`, in its order; a bit a point
/// of the slice besides. An empty block takes over the slice's origin and columns.
/// throws as read_slice; FormatError if the columns are others than those of `out`
void append_slice_part(const std::string& path,
                       const std::function<bool(const Vec3d&)>& is_wanted, PointBlock& out);

/// The same for the points whose id is wanted.
void append_slice_points(const std::string& path,
                         const std::function<bool(std::uint64_t id)>& is_wanted, PointBlock& out);

}  // namespace slim
