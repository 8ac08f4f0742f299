#pragma once

#include "formats/chunk_file.h"
#include "slim/model/surfel_tree.h"

#include <string>

namespace slim {

/// Writes model.slim: header, page origins, surfel records, nodes, and a JSON text of provenance.
/// Equal data give equal bytes. Throws as AtomicFile.
void write_model(const std::string& path, const SurfelTreeData& data,
                 const std::string& provenance_json);

/// model.slim mapped into memory.
class ModelFile {
public:
    /// Checks every chunk's checksum, then the tree itself (see check_model).
    /// throws FormatError naming the file, the chunk and byte, the node and the reason; IoError
    static ModelFile open(const std::string& path);

    /// Views into the mapped file; valid as long as this object.
    SurfelTree tree() const;
    const ModelHeader& header() const { return header_; }
    const std::string& provenance_json() const { return provenance_; }
    std::uint64_t file_size() const { return file_.file_size(); }
    const std::string& path() const { return file_.path(); }

private:
    explicit ModelFile(ChunkFile file) : file_(std::move(file)) {}

    ChunkFile file_;
    ModelHeader header_;
    std::string provenance_;
};

}  // namespace slim
