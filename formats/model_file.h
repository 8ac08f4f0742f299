#pragma once

#include "formats/chunk_file.h"
#include "slim/model/surfel_color.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <span>
#include <string>

namespace slim {

/// Writes model.slim: header, page origins, surfel records, nodes, and a JSON text of provenance.
/// Equal data give equal bytes. Throws as AtomicFile.
void write_model(const std::string& path, const SurfelTreeData& data,
                 const std::string& provenance_json);

/// Writes a model again with a colour for each of its nodes, all else as it is. Throws as
/// ModelFile::open and AtomicFile.
void write_model_colors(const std::string& path, std::span<const PackedColor> colors);

/// model.slim mapped into memory.
class ModelFile {
public:
    /// Checks every chunk's checksum, attributes and all, then the tree itself (see check_model).
    /// throws FormatError naming the file, the chunk and byte, the node and the reason; IoError
    static ModelFile open(const std::string& path);

    /// What open_by_pages reads, where it is there.
    static constexpr const char* kSmallChunks[] = {
        "header", "drawn", "hull", "loose_hull", "provenance", "pages", "page_start", "in_page"};
    /// Checks and reads only the table and the small chunks: header, boxes and hulls of what is
    /// drawn, provenance, page origins and the index of records: for views of a part. Before nodes
    /// and records are used either check() them all, or those of a list.
    static ModelFile open_by_pages(const std::string& path);
    /// All that open() checks, but for attributes (colours): no page of theirs is read.
    static ModelFile open_surface(const std::string& path);
    /// The rest of what open_surface() checks.
    void check() const;
    /// Checks the colours' checksum; nothing without colours. throws FormatError
    void check_colors() const;
    /// Checks nodes and records of a list as open() would, but for checksums and parents.
    /// throws FormatError
    void check(std::span<const std::uint32_t> nodes) const;
    /// See ChunkFile.
    std::string identity() const { return file_.identity(); }

    /// Views into the mapped file; valid as long as this object.
    SurfelTree tree() const;
    const ModelHeader& header() const { return header_; }
    /// A colour a node; empty if the model has none. No page of it is read before it is looked at.
    std::span<const PackedColor> colors() const;
    const std::string& provenance_json() const { return provenance_; }
    std::uint64_t file_size() const { return file_.file_size(); }
    /// Bytes of the file that are no attribute's.
    std::uint64_t surface_size() const;
    /// Bytes of the colours; 0 without.
    std::uint64_t colors_size() const;
    const std::string& path() const { return file_.path(); }
    /// Where things are in the file.
    const ChunkFile& chunks() const { return file_; }

private:
    explicit ModelFile(ChunkFile file) : file_(std::move(file)) {}
    void read_small_chunks();
    [[noreturn]] void fail(const struct ModelFault& fault) const;

    ChunkFile file_;
    ModelHeader header_;
    std::string provenance_;
};

}  // namespace slim
