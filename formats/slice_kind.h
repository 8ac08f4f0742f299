#pragma once

#include "formats/chunk_file.h"

#include <cstdint>

namespace slim {

/// Slices are files of a work folder: of the version before, without pieces, none is read.
inline constexpr ChunkFileKind kSliceKind{"SLIMSLCE", "SLIM slice", 2};

/// The chunk "columns": which optional ones the points have.
struct SliceColumns {
    std::uint32_t has_normals, has_scans;
};

}  // namespace slim
