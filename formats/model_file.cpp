#include "formats/model_file.h"

#include "formats/message.h"
#include "formats/model_check.h"
#include "slim/base/error.h"

#include <utility>

namespace slim {
namespace {

/// Version 2 has further sheets of sharp surfels, version 3 an index of records of unequal size; a
/// model is of the lowest version that holds it.
constexpr ChunkFileKind kSmoothModelKind{"SLIMTREE", "SLIM model", 1};
constexpr ChunkFileKind kSharpModelKind{"SLIMTREE", "SLIM model", 2};
constexpr ChunkFileKind kModelKind{"SLIMTREE", "SLIM model", 3};

/// ModelHeader as it stands in the file: no gaps, sizes fixed.
struct HeaderRecord {
    std::int32_t degree;
    std::uint32_t reserved;
    Vec3d origin, lo, hi;
    double diagonal, noise_variance, mdl_threshold;
    std::uint64_t n_points, n_leaves, seed;
};
static_assert(sizeof(HeaderRecord) == 8 + 9 * 8 + 3 * 8 + 3 * 8);

HeaderRecord pack(const ModelHeader& h) {
    return {h.degree,   0,          h.origin,         h.bounds.lo,     h.bounds.hi, h.diagonal,
            h.noise_variance, h.mdl_threshold, h.n_points, h.n_leaves, h.seed};
}

ModelHeader unpack(const HeaderRecord& r) {
    return {r.degree,         r.origin,        {r.lo, r.hi}, r.diagonal, r.noise_variance,
            r.mdl_threshold, r.n_points,      r.n_leaves,   r.seed};
}

ModelHeader read_header(const ChunkFile& file) {
    const auto records = file.array<HeaderRecord>("header");
    if (records.size() != 1)
        throw FormatError(message(file.path(), ": byte ", file.offset("header"),
                                  ": expected one header, found ", records.size()));
    return unpack(records[0]);
}

std::uint64_t byte_of(const ChunkFile& file, const SurfelTree& tree, const ModelFault& fault) {
    if (fault.chunk == "records")
        return file.offset(fault.chunk) +
               sizeof(float) *
                   static_cast<std::uint64_t>(tree.record(fault.entry) - tree.records().data());
    const std::size_t size = fault.chunk == "nodes"     ? sizeof(TreeNode)
                             : fault.chunk == "pages"   ? sizeof(Vec3d)
                             : fault.chunk == "sharp"   ? sizeof(SharpEntry)
                             : fault.chunk == "in_page" ? sizeof(std::uint16_t)
                             : fault.chunk == "sheets"  ? sizeof(float)
                                                        : 0;
    return file.offset(fault.chunk) + fault.entry * size;
}

}  // namespace

void write_model(const std::string& path, const SurfelTreeData& data,
                 const std::string& provenance_json) {
    const HeaderRecord header = pack(data.header);
    ChunkWriter writer(path, !data.in_page.empty() ? kModelKind
                             : !data.sharp.empty() ? kSharpModelKind
                                                   : kSmoothModelKind);
    writer.add("header", std::span<const HeaderRecord>(&header, 1));
    writer.add("provenance", std::span<const char>(provenance_json));
    writer.add("pages", std::span<const Vec3d>(data.page_origins));
    writer.add("nodes", std::span<const TreeNode>(data.nodes));
    writer.add("records", std::span<const float>(data.records));
    if (!data.in_page.empty()) {
        writer.add("page_start", std::span<const std::uint64_t>(data.page_start));
        writer.add("in_page", std::span<const std::uint16_t>(data.in_page));
    }
    if (!data.sharp.empty()) {
        writer.add("sharp", std::span<const SharpEntry>(data.sharp));
        writer.add("sheets", std::span<const float>(data.sheets));
    }
    writer.commit();
}

ModelFile ModelFile::open(const std::string& path) {
    ModelFile model(ChunkFile::open(path, kModelKind));
    const ChunkFile& file = model.file_;
    file.verify_all();
    model.header_ = read_header(file);
    const auto json = file.array<char>("provenance");
    model.provenance_.assign(json.begin(), json.end());
    const SurfelTree tree = model.tree();
    const ModelFault fault = check_model(tree);
    if (!fault.chunk.empty())
        throw FormatError(message(path, ": byte ", byte_of(file, tree, fault), ": chunk ",
                                  fault.chunk, ", node ", fault.entry, ": ", fault.reason));
    return model;
}

SurfelTree ModelFile::tree() const {
    std::span<const SharpEntry> sharp;
    std::span<const float> sheets;
    if (file_.has("sharp")) {
        sharp = file_.array<SharpEntry>("sharp");
        sheets = file_.array<float>("sheets");
    }
    RecordIndex index;
    if (file_.has("in_page"))
        index = {file_.array<std::uint64_t>("page_start"), file_.array<std::uint16_t>("in_page")};
    return {header_, file_.array<Vec3d>("pages"), file_.array<float>("records"),
            file_.array<TreeNode>("nodes"), sharp, sheets, index};
}

}  // namespace slim
