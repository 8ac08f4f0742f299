#include "formats/model_file.h"

#include "formats/message.h"
#include "formats/model_check.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

namespace slim {
namespace {

/// Version 2 has further sheets of sharp surfels, version 3 an index of records of unequal size,
/// version 4 leaves of two rims, version 5 corners of more than three sheets; a model is of the
/// lowest version that holds it.
constexpr ChunkFileKind kSmoothModelKind{"SLIMTREE", "SLIM model", 1};
constexpr ChunkFileKind kSharpModelKind{"SLIMTREE", "SLIM model", 2};
constexpr ChunkFileKind kMixedModelKind{"SLIMTREE", "SLIM model", 3};
constexpr ChunkFileKind kTwoRimsModelKind{"SLIMTREE", "SLIM model", 4};
constexpr ChunkFileKind kModelKind{"SLIMTREE", "SLIM model", 5};

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
    return {r.degree,        r.origin,   {r.lo, r.hi}, r.diagonal, r.noise_variance,
            r.mdl_threshold, r.n_points, r.n_leaves,   r.seed,     {}, {}, {}, {}};
}

/// One of "drawn": the box without loose surfels, then that with them.
struct BoxRecord {
    Vec3d lo, hi;
};
static_assert(sizeof(BoxRecord) == 6 * 8);

/// A place of "hull": where it lies in the box of what is drawn, of "loose_hull" in that with loose
/// surfels.
using HullRecord = std::array<std::uint16_t, 3>;
static_assert(sizeof(HullRecord) == 6);
constexpr double kHullSteps = 65535;
constexpr std::size_t kMostHull = 386;  // directions of slim/tree/drawn_hull.h

std::vector<HullRecord> pack_hull(std::span<const Vec3d> hull, const Bbox& box) {
    std::vector<HullRecord> out(hull.size());
    for (std::size_t i = 0; i < hull.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double extent = box.hi[axis] - box.lo[axis];
            const double share = extent > 0 ? (hull[i][axis] - box.lo[axis]) / extent : 0;
            out[i][axis] =
                static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * kHullSteps));
        }
    return out;
}

/// The box's own numbers at both ends.
std::vector<Vec3d> read_hull(const ChunkFile& file, const char* chunk, const Bbox& box) {
    std::vector<Vec3d> hull;
    if (!file.has(chunk)) return hull;
    const auto records = file.array<HullRecord>(chunk);
    if (records.size() > kMostHull || (box.empty() && !records.empty()))
        throw FormatError(message(file.path(), ": byte ", file.offset(chunk), ": ", chunk,
                                  ": expected at most ", box.empty() ? 0 : kMostHull,
                                  " places in the box of what is drawn, found ", records.size()));
    for (const HullRecord& r : records) {
        Vec3d p = box.hi;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (r[axis] < kHullSteps)
                p[axis] = box.lo[axis] + (box.hi[axis] - box.lo[axis]) * (r[axis] / kHullSteps);
        hull.push_back(p);
    }
    return hull;
}

/// Whether a chunk says what the surface is; all others are attributes of it.
bool is_of_surface(std::string_view chunk) {
    constexpr std::string_view kLarge[] = {"nodes", "records", "sharp", "sheets"};
    return std::find(std::begin(ModelFile::kSmallChunks), std::end(ModelFile::kSmallChunks),
                     chunk) != std::end(ModelFile::kSmallChunks) ||
           std::find(std::begin(kLarge), std::end(kLarge), chunk) != std::end(kLarge);
}

ModelHeader read_header(const ChunkFile& file) {
    const auto records = file.array<HeaderRecord>("header");
    if (records.size() != 1)
        throw FormatError(message(file.path(), ": byte ", file.offset("header"),
                                  ": expected one header, found ", records.size()));
    ModelHeader header = unpack(records[0]);
    if (!file.has("drawn")) return header;
    const auto boxes = file.array<BoxRecord>("drawn");
    if (boxes.size() != 2)
        throw FormatError(message(file.path(), ": byte ", file.offset("drawn"),
                                  ": expected two boxes, found ", boxes.size()));
    header.drawn = {boxes[0].lo, boxes[0].hi};
    header.drawn_loose = {boxes[1].lo, boxes[1].hi};
    header.hull = read_hull(file, "hull", header.drawn);
    header.loose_hull = read_hull(file, "loose_hull", header.drawn_loose);
    return header;
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

void write_arrays(const std::string& path, const SurfelTree& tree,
                  const std::string& provenance_json, std::span<const PackedColor> colors) {
    const HeaderRecord header = pack(tree.header());
    const bool two_rims = std::any_of(tree.nodes().begin(), tree.nodes().end(),
                                      [](const TreeNode& n) { return n.rims().second != 0; });
    const bool many_sheets =
        std::any_of(tree.sharp().begin(), tree.sharp().end(),
                    [](const SharpEntry& e) { return e.n_extra >= kUsualSheets; });
    const RecordIndex& index = tree.record_index();
    ChunkWriter writer(path, many_sheets             ? kModelKind
                             : two_rims              ? kTwoRimsModelKind
                             : !index.empty()        ? kMixedModelKind
                             : !tree.sharp().empty() ? kSharpModelKind
                                                     : kSmoothModelKind);
    writer.add("header", std::span<const HeaderRecord>(&header, 1));
    const ModelHeader& h = tree.header();
    const BoxRecord drawn[] = {{h.drawn.lo, h.drawn.hi}, {h.drawn_loose.lo, h.drawn_loose.hi}};
    if (!h.drawn.empty()) writer.add("drawn", std::span<const BoxRecord>(drawn));
    if (!h.hull.empty())
        writer.add("hull", std::span<const HullRecord>(pack_hull(h.hull, h.drawn)));
    if (!h.loose_hull.empty())
        writer.add("loose_hull",
                   std::span<const HullRecord>(pack_hull(h.loose_hull, h.drawn_loose)));
    writer.add("provenance", std::span<const char>(provenance_json));
    writer.add("pages", tree.page_origins());
    writer.add("nodes", tree.nodes());
    writer.add("records", tree.records());
    if (!index.empty()) {
        writer.add("page_start", index.page_start);
        writer.add("in_page", index.in_page);
    }
    if (!tree.sharp().empty()) {
        writer.add("sharp", tree.sharp());
        writer.add("sheets", tree.sheets());
    }
    if (!colors.empty()) writer.add("colors", colors);
    writer.commit();
}

}  // namespace

void write_model(const std::string& path, const SurfelTreeData& data,
                 const std::string& provenance_json) {
    write_arrays(path, data.view(), provenance_json, {});
}

void write_model_colors(const std::string& path, std::span<const PackedColor> colors) {
    const ModelFile model = ModelFile::open(path);
    SLIM_CHECK(colors.size(), ==, model.tree().n_nodes());
    write_arrays(path, model.tree(), model.provenance_json(), colors);
}

std::span<const PackedColor> ModelFile::colors() const {
    if (!file_.has("colors")) return {};
    const auto colors = file_.array<PackedColor>("colors");
    if (colors.size() != tree().n_nodes())
        throw FormatError(message(file_.path(), ": byte ", file_.offset("colors"), ": ",
                                  colors.size(), " colours for ", tree().n_nodes(), " nodes"));
    return colors;
}

void ModelFile::read_small_chunks() {
    header_ = read_header(file_);
    const auto json = file_.array<char>("provenance");
    provenance_.assign(json.begin(), json.end());
}

void ModelFile::fail(const ModelFault& fault) const {
    throw FormatError(message(file_.path(), ": byte ", byte_of(file_, tree(), fault), ": chunk ",
                              fault.chunk, ", node ", fault.entry, ": ", fault.reason));
}

ModelFile ModelFile::open(const std::string& path) {
    ModelFile model(ChunkFile::open(path, kModelKind));
    model.file_.verify_all();
    model.read_small_chunks();
    if (const ModelFault fault = check_model(model.tree()); !fault.chunk.empty()) model.fail(fault);
    model.colors();
    return model;
}

ModelFile ModelFile::open_by_pages(const std::string& path) {
    ModelFile model(ChunkFile::open(path, kModelKind, true));
    for (const char* chunk : kSmallChunks)
        if (model.file_.has(chunk)) model.file_.verify(chunk);
    model.read_small_chunks();
    if (const ModelFault fault = check_sizes(model.tree()); !fault.chunk.empty()) model.fail(fault);
    return model;
}

ModelFile ModelFile::open_surface(const std::string& path) {
    ModelFile model = open_by_pages(path);
    model.check();
    return model;
}

void ModelFile::check() const {
    for (const std::string& name : file_.names()) {
        if (!is_of_surface(name)) continue;
        file_.read_ahead(name);
        file_.verify(name);
    }
    if (const ModelFault fault = check_model(tree()); !fault.chunk.empty()) fail(fault);
}

void ModelFile::check_colors() const {
    if (!file_.has("colors")) return;
    file_.read_ahead("colors");
    file_.verify("colors");
}

std::uint64_t ModelFile::surface_size() const {
    std::uint64_t size = file_.file_size();
    for (const std::string& name : file_.names())
        if (!is_of_surface(name)) size -= file_.n_bytes(name);
    return size;
}

std::uint64_t ModelFile::colors_size() const {
    return file_.has("colors") ? file_.n_bytes("colors") : 0;
}

void ModelFile::check(std::span<const std::uint32_t> nodes) const {
    const SurfelTree all = tree();
    for (const std::uint32_t i : nodes)
        if (const ModelFault fault = check_alone(all, i); !fault.chunk.empty()) fail(fault);
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
