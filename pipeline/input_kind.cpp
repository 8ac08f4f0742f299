#include "pipeline/input_kind.h"

#include "formats/cloud_endings.h"
#include "formats/extension.h"
#include "formats/made_folders.h"
#include "formats/point_source.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <string_view>
#include <unistd.h>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// Of clouds that are not read, meshes, pictures and texts.
constexpr auto kOtherEndings = std::to_array<std::string_view>(
    {".las", ".laz",  ".e57", ".pcd", ".ptx",  ".obj",  ".off", ".stl",
     ".glb", ".vtk",  ".gz",  ".zip", ".png",  ".exr",  ".jpg", ".jpeg",
     ".tif", ".tiff", ".svg", ".pdf", ".json", ".toml", ".html"});

/// Without reading on: of a large model no more may be wanted than a few pages.
bool begins_with(const std::string& path, const std::string& magic) {
    std::string head(magic.size(), '\0');
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return false;
    ::posix_fadvise(file, 0, 0, POSIX_FADV_RANDOM);
    const bool whole =
        ::pread(file, head.data(), head.size(), 0) == static_cast<ssize_t>(head.size());
    ::close(file);
    return whole && head == magic;
}

/// Whether a file wants to be a cloud, by its first bytes or its name.
bool names_a_cloud(const std::string& path) {
    const bool packed = lower_extension(path) == ".gz";
    const std::string ending = lower_extension(packed ? path.substr(0, path.size() - 3) : path);
    return begins_with(path, "ply\n") || begins_with(path, "ply\r") || is_cloud_ending(ending);
}

/// Throws what is wrong with a cloud that yields no point.
[[noreturn]] void say_what_is_wrong(const std::string& path) {
    PointChunk chunk;
    open_cloud(path)->read(chunk, 1);
    throw DataError(path +
                    ": holds no point; expected a model (model.slim), as `slim build` writes");
}

bool has_a_point(const std::string& path) {
    try {
        PointChunk chunk;
        return open_cloud(path)->read(chunk, 1);
    } catch (const std::exception&) {
        return false;
    }
}

}  // namespace

InputKind input_kind(const std::string& path) {
    std::error_code error;
    if (!fs::exists(path, error)) return InputKind::missing;
    if (fs::is_directory(path, error)) return InputKind::folder;
    if (begins_with(path, "SLIMTREE")) return InputKind::model;
    return has_a_point(path) ? InputKind::cloud : InputKind::other;
}

void refuse_to_replace_other(const std::string& output) {
    std::error_code none;
    if (!fs::is_regular_file(output, none) || fs::file_size(output, none) == 0) return;
    const InputKind kind = input_kind(output);
    const bool is_cloud = kind == InputKind::cloud;
    if (kind == InputKind::model || (!is_cloud && fs::path(output).extension() == ".slim")) return;
    throw ConfigError({.file = output,
                       .problem = fmt::format("is there already and is {}, not a model; name "
                                              "another file or remove it",
                                              is_cloud ? "a cloud" : "some other file")});
}

void refuse_other_ending(const std::string& model) {
    const std::string ending = lower_extension(model);
    if (!is_cloud_ending(ending) &&
        std::find(kOtherEndings.begin(), kOtherEndings.end(), ending) == kOtherEndings.end())
        return;
    throw ConfigError({.file = model,
                       .problem = fmt::format("a model is written, no {} file", ending),
                       .expected = "a name ending in .slim, as " +
                                   fs::path(model).replace_extension(".slim").string()});
}

void refuse_to_overwrite(const std::string& output, std::initializer_list<std::string> inputs) {
    std::error_code none;
    for (const std::string& input : inputs)
        if (!input.empty() && !output.empty() && std::filesystem::equivalent(input, output, none))
            throw ConfigError({.file = output,
                               .problem = "is an input",
                               .expected = "another name to write to"});
}

void make_writable_folder(const fs::path& folder) {
    make_folders(folder.string());
    if (::access(folder.c_str(), W_OK) != 0)
        throw IoError({.file = folder.string(),
                       .problem =
                           std::string("cannot write into this folder: ") + std::strerror(errno)},
                      ExitCode::usage);
}

void require_model(const std::string& path) {
    const InputKind kind = input_kind(path);
    if (kind == InputKind::folder)
        throw ConfigError({.file = path,
                           .problem = "is a folder",
                           .expected = "a model (model.slim), as `slim build` writes"});
    if (kind == InputKind::other && names_a_cloud(path)) say_what_is_wrong(path);
    if (kind != InputKind::cloud) return;
    fs::path model = fs::path(path).filename();
    if (lower_extension(path) == ".gz") model.replace_extension();
    model.replace_extension(".slim");
    throw FormatError(
        fmt::format("{0}: a point cloud, not a model; build it first: slim build {0} -o {1}", path,
                    model.string()));
}

}  // namespace slim
