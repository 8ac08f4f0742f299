#pragma once

#include "formats/model_file.h"
#include "formats/model_pages.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// What a run reads of a model, and checks before it is drawn, once each: all of its surface, or
/// node by node what its views meet; colours only if they are shown. Nodes and records that are
/// checked by themselves are so without the checksum of the chunks that they are part of: that is
/// one of the whole chunk.
class ModelReads {
public:
    /// Checks a model at once that is taken whole, is small (16 MiB), or has sharp surfels.
    /// The file must outlive this object. throws FormatError
    ModelReads(const ModelFile& model, bool taken_whole, bool with_colors);

    /// To be called before the surfels of these nodes are drawn: checks those that it did not meet
    /// before; from half of the surface's bytes on all of it. throws FormatError
    /// cost  O(nodes met), memory a bit a node
    void meet(std::span<const std::uint32_t> nodes);

    /// Whether all of the surface is checked and there is nothing to be met.
    bool whole() const { return whole_; }
    /// Of the file's pages that were read; of chunks that were taken whole their own.
    std::uint64_t bytes() const {
        return (whole_ ? model_.surface_size() : pages_.bytes()) + color_bytes_;
    }
    /// Nodes that were checked by themselves.
    std::uint64_t n_checked() const { return n_checked_; }

private:
    void check_whole();

    const ModelFile& model_;
    ModelPages pages_;
    std::vector<bool> met_;
    std::vector<std::uint32_t> fresh_;  ///< of one call
    std::uint64_t n_checked_ = 0, color_bytes_ = 0;
    bool whole_ = false;
};

}  // namespace slim
