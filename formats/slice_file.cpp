#include "formats/slice_file.h"

#include "formats/message.h"
#include "slim/base/check.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"

namespace slim {
namespace {

constexpr ChunkFileKind kSliceKind{"SLIMSLCE", "SLIM slice", 1};

/// What of a column comes along: point i if keep(i).
template <class T, class Keep>
std::vector<T> read_column(const ChunkFile& file, const char* name, std::size_t n, const Keep& keep) {
    const std::size_t found = file.array<T>(name).size();
    if (found != n)
        throw FormatError(message(file.path(), ": byte ", file.offset(name), ": chunk ", name,
                                  ": expected ", n, " entries, found ", found));
    std::vector<T> out;
    file.for_pieces<T>(name, [&](std::size_t first, std::span<const T> piece) { keep(first, piece, out); });
    return out;
}

/// The columns of a slice after its positions have been chosen from.
template <class Keep>
void read_columns(const ChunkFile& file, std::size_t n, const Keep& keep, PointBlock& block) {
    const auto everything = [](std::size_t, auto piece, auto& out) {
        out.insert(out.end(), piece.begin(), piece.end());
    };
    block.origin = read_column<Vec3d>(file, "origin", 1, everything)[0];
    // Half of the bytes are positions.
    run_both([&] { block.position = read_column<Vec3d>(file, "position", n, keep); }, [&] {
        block.id = read_column<std::uint64_t>(file, "id", n, keep);
        if (!file.array<Vec3f>("normal").empty())
            block.normal = read_column<Vec3f>(file, "normal", n, keep);
        if (!file.array<std::uint16_t>("scan").empty())
            block.scan = read_column<std::uint16_t>(file, "scan", n, keep);
    });
}

}  // namespace

SliceWriter::SliceWriter(const std::string& path, const Vec3d& origin, std::uint64_t n_points,
                         bool has_normals, bool has_scans)
    : chunks_(path, kSliceKind), has_normals_(has_normals), has_scans_(has_scans) {
    chunks_.add("origin", std::span<const Vec3d>(&origin, 1));
    position_ = chunks_.reserve("position", sizeof(Vec3d), n_points);
    id_ = chunks_.reserve("id", sizeof(std::uint64_t), n_points);
    normal_ = chunks_.reserve("normal", sizeof(Vec3f), has_normals ? n_points : 0);
    scan_ = chunks_.reserve("scan", sizeof(std::uint16_t), has_scans ? n_points : 0);
}

void SliceWriter::append(const PointBlock& block) {
    const std::size_t n = block.size();
    SLIM_CHECK(block.id.size(), ==, n);
    SLIM_CHECK(block.normal.size(), ==, has_normals_ ? n : 0);
    SLIM_CHECK(block.scan.size(), ==, has_scans_ ? n : 0);
    chunks_.append(position_, block.position.data(), n);
    chunks_.append(id_, block.id.data(), n);
    chunks_.append(normal_, block.normal.data(), block.normal.size());
    chunks_.append(scan_, block.scan.data(), block.scan.size());
}

void write_slice(const std::string& path, const PointBlock& block) {
    SliceWriter writer(path, block.origin, block.size(), block.has_normals(), block.has_scans());
    writer.append(block);
    writer.commit();
}

PointBlock read_slice(const std::string& path) {
    const ChunkFile file = ChunkFile::open(path, kSliceKind);
    const std::size_t n = file.array<Vec3d>("position").size();
    PointBlock block;
    read_columns(file, n, [n](std::size_t, auto piece, auto& out) {
        out.reserve(n);
        out.insert(out.end(), piece.begin(), piece.end());
    }, block);
    return block;
}

PointBlock read_slice_part(const std::string& path, int axis, double lo, double hi) {
    const ChunkFile file = ChunkFile::open(path, kSliceKind);
    const std::size_t n = file.array<Vec3d>("position").size();
    std::vector<bool> wanted(n);
    file.for_pieces<Vec3d>("position", [&](std::size_t first, std::span<const Vec3d> piece) {
        for (std::size_t i = 0; i < piece.size(); ++i) {
            const double x = piece[i][static_cast<std::size_t>(axis)];
            wanted[first + i] = x >= lo && x <= hi;
        }
    });
    PointBlock block;
    read_columns(file, n, [&](std::size_t first, auto piece, auto& out) {
        for (std::size_t i = 0; i < piece.size(); ++i)
            if (wanted[first + i]) out.push_back(piece[i]);
    }, block);
    return block;
}

}  // namespace slim
