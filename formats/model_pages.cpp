#include "formats/model_pages.h"

namespace slim {

ModelPages::ModelPages(const ModelFile& model)
    : tree_(model.tree()),
      node_chunk_(model.chunks().offset("nodes")),
      record_chunk_(model.chunks().offset("records")),
      touched_((model.file_size() + kPage - 1) / kPage) {
    touch(0, 1);                      // of the file's header
    touch(model.file_size() - 1, 1);  // the table
    for (const char* chunk : ModelFile::kSmallChunks)
        if (model.chunks().has(chunk))
            touch(model.chunks().offset(chunk), model.chunks().n_bytes(chunk));
}

void ModelPages::add(std::uint32_t node) {
    touch(node_chunk_ + node * sizeof(TreeNode), sizeof(TreeNode));
    const auto first = static_cast<std::uint64_t>(tree_.record(node) - tree_.records().data());
    const auto length = static_cast<std::uint64_t>(floats_per_surfel(tree_.record_degree(node)));
    touch(record_chunk_ + sizeof(float) * first, sizeof(float) * length);
}

void ModelPages::touch(std::uint64_t offset, std::uint64_t n_bytes) {
    if (n_bytes == 0) return;
    for (std::uint64_t page = offset / kPage; page <= (offset + n_bytes - 1) / kPage; ++page)
        if (!touched_[page]) touched_[page] = true, ++n_;
}

}  // namespace slim
