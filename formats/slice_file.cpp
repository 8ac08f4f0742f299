#include "formats/slice_file.h"

#include "formats/message.h"
#include "slim/base/check.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <vector>

namespace slim {
namespace {

constexpr ChunkFileKind kSliceKind{"SLIMSLCE", "SLIM slice", 1};

template <class T>
std::span<const T> column(const ChunkFile& file, const char* name, std::size_t n) {
    const std::span<const T> values = file.array<T>(name);
    if (values.size() != n)
        throw FormatError(message(file.path(), ": byte ", file.offset(name), ": chunk ", name,
                                  ": expected ", n, " entries, found ", values.size()));
    return values;
}

/// Appends what is wanted of a column; the vector holds nothing to spare.
template <class T>
void append_column(const ChunkFile& file, const char* name, const std::vector<bool>& wanted,
                   std::size_t n_wanted, std::vector<T>& out) {
    column<T>(file, name, wanted.size());
    out.reserve(out.size() + n_wanted);
    file.for_pieces<T>(name, [&](std::size_t first, std::span<const T> piece) {
        if (n_wanted == wanted.size()) {
            out.insert(out.end(), piece.begin(), piece.end());
            return;
        }
        for (std::size_t i = 0; i < piece.size(); ++i)
            if (wanted[first + i]) out.push_back(piece[i]);
    });
}

/// The columns of a slice's wanted points; optional ones are empty or those of every point.
void append_columns(const ChunkFile& file, const std::vector<bool>& wanted, PointBlock& out) {
    const auto n = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), true));
    const bool has_normals = !file.array<Vec3f>("normal").empty();
    const bool has_scans = !file.array<std::uint16_t>("scan").empty();
    if (n == 0 && !out.empty()) return;
    if (!out.empty() && (has_normals != out.has_normals() || has_scans != out.has_scans()))
        throw FormatError(message(file.path(), ": has other columns than the slices before it"));
    file.verify("origin");
    out.origin = column<Vec3d>(file, "origin", 1)[0];
    // Half of the bytes are positions.
    run_both([&] { append_column(file, "position", wanted, n, out.position); }, [&] {
        append_column(file, "id", wanted, n, out.id);
        if (has_normals) append_column(file, "normal", wanted, n, out.normal);
        if (has_scans) append_column(file, "scan", wanted, n, out.scan);
    });
}

/// The bits of the points whose values in a column are wanted.
template <class T, class Wanted>
std::vector<bool> choose_by(const ChunkFile& file, const char* name, Wanted&& is_wanted) {
    std::vector<bool> wanted(file.array<T>(name).size());
    file.for_pieces<T>(name, [&](std::size_t first, std::span<const T> piece) {
        for (std::size_t i = 0; i < piece.size(); ++i) wanted[first + i] = is_wanted(piece[i]);
    });
    return wanted;
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
    PointBlock block;
    append_columns(file, std::vector<bool>(file.array<Vec3d>("position").size(), true), block);
    return block;
}

void append_slice_part(const std::string& path,
                       const std::function<bool(const Vec3d&)>& is_wanted, PointBlock& out) {
    const ChunkFile file = ChunkFile::open(path, kSliceKind);
    append_columns(file, choose_by<Vec3d>(file, "position", is_wanted), out);
}

void append_slice_points(const std::string& path,
                         const std::function<bool(std::uint64_t id)>& is_wanted, PointBlock& out) {
    const ChunkFile file = ChunkFile::open(path, kSliceKind);
    append_columns(file, choose_by<std::uint64_t>(file, "id", is_wanted), out);
}

}  // namespace slim
