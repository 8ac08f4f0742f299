#pragma once

#include "formats/model_file.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Pages (4 KiB) of a model file that a run has read, each counted once.
class ModelPages {
public:
    /// Those that ModelFile::open_by_pages reads. The file must outlive this object.
    explicit ModelPages(const ModelFile& model);

    /// Those of a node and its record.
    void add(std::uint32_t node);
    std::uint64_t bytes() const { return kPage * n_; }

private:
    static constexpr std::uint64_t kPage = 4096;

    void touch(std::uint64_t offset, std::uint64_t n_bytes);

    SurfelTree tree_;
    std::uint64_t node_chunk_, record_chunk_;  ///< byte offsets
    std::vector<bool> touched_;
    std::uint64_t n_ = 0;
};

}  // namespace slim
