#include "formats/slice_file.h"

#include "formats/message.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

namespace slim {
namespace {

constexpr ChunkFileKind kSliceKind{"SLIMSLCE", "SLIM slice", 1};

template <class T>
std::vector<T> read_column(const ChunkFile& file, const char* name, std::size_t n) {
    const auto values = file.array<T>(name);
    if (values.size() != n)
        throw FormatError(message(file.path(), ": byte ", file.offset(name), ": chunk ", name,
                                  ": expected ", n, " entries, found ", values.size()));
    return {values.begin(), values.end()};
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
    file.verify_all();
    PointBlock block;
    block.origin = read_column<Vec3d>(file, "origin", 1)[0];
    const auto positions = file.array<Vec3d>("position");
    const std::size_t n = positions.size();
    block.position.assign(positions.begin(), positions.end());
    block.id = read_column<std::uint64_t>(file, "id", n);
    if (!file.array<Vec3f>("normal").empty()) block.normal = read_column<Vec3f>(file, "normal", n);
    if (!file.array<std::uint16_t>("scan").empty())
        block.scan = read_column<std::uint16_t>(file, "scan", n);
    return block;
}

}  // namespace slim
