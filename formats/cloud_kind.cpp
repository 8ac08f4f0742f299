#include "formats/cloud_kind.h"

#include "formats/cloud_endings.h"
#include "formats/message.h"
#include "slim/base/error.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace slim {
namespace {

std::string what_is_read() {
    return "read are PLY (ascii, binary of either byte order) and text of coordinates (" +
           text_endings(" ", " ") + "), each also packed with gzip";
}

constexpr const char* kPdal =
    "; convert with: pdal translate IN OUT.ply --writers.ply.storage_mode=\"little endian\"";
constexpr const char* kMeshlab = "; export it as PLY, for example with MeshLab or Blender";
constexpr const char* kNone = "";

struct KnownFormat {
    std::string_view key;  ///< first bytes, or extension
    const char* name;
    const char* advice;
};

using namespace std::string_view_literals;

constexpr std::array kMagics{
    KnownFormat{"ASTM-E57"sv, "an E57 file", kPdal},
    KnownFormat{"LASF"sv, "a LAS or LAZ file", kPdal},
    KnownFormat{"# .PCD"sv, "a PCD file", kPdal},
    KnownFormat{"VERSION .7"sv, "a PCD file", kPdal},
    KnownFormat{"VERSION 0.7"sv, "a PCD file", kPdal},
    KnownFormat{"DRACO"sv, "a Draco file", "; convert with: draco_decoder -i IN -o OUT.ply"},
    KnownFormat{"OFF"sv, "an OFF mesh", kMeshlab},
    KnownFormat{"COFF"sv, "an OFF mesh", kMeshlab},
    KnownFormat{"NOFF"sv, "an OFF mesh", kMeshlab},
    KnownFormat{"solid"sv, "an STL mesh", kMeshlab},
    KnownFormat{"glTF"sv, "a glTF file", kMeshlab},
    KnownFormat{"Kaydara FBX"sv, "an FBX file", kMeshlab},
    KnownFormat{"# vtk DataFile"sv, "a VTK file", kMeshlab},
    KnownFormat{"[Expe/PointSet"sv, "an Expe point set", kNone},
    KnownFormat{"SLIMTREE"sv, "a SLIM model, not a cloud", "; it is what `slim render` takes"},
    KnownFormat{"SLIMSLCE"sv, "a slice of a build, not a cloud", kNone},
    KnownFormat{"SLIMFITS"sv, "a fit of a build, not a cloud", kNone},
    KnownFormat{"\x89PNG"sv, "a PNG image", kNone},
    KnownFormat{"\xff\xd8\xff"sv, "a JPEG image", kNone},
    KnownFormat{"\x76\x2f\x31\x01"sv, "an EXR image", kNone},
    KnownFormat{"II*\0"sv, "a TIFF image", kNone},
    KnownFormat{"MM\0*"sv, "a TIFF image", kNone},
    KnownFormat{"\x89HDF"sv, "an HDF5 file", kNone},
    KnownFormat{"PK\x03\x04"sv, "a zip archive", "; unpack it first"},
    KnownFormat{"BZh"sv, "a bzip2 file", "; unpack it first"},
    KnownFormat{"\xfd" "7zXZ"sv, "an xz file", "; unpack it first"},
    KnownFormat{"\x28\xb5\x2f\xfd"sv, "a zstd file", "; unpack it first"},
    KnownFormat{"%PDF"sv, "a PDF", kNone},
};

constexpr std::array kExtensions{
    KnownFormat{"las"sv, "a LAS file", kPdal},
    KnownFormat{"laz"sv, "a LAZ file", kPdal},
    KnownFormat{"e57"sv, "an E57 file", kPdal},
    KnownFormat{"pcd"sv, "a PCD file", kPdal},
    KnownFormat{"ptx"sv, "a PTX file", kPdal},
    KnownFormat{"obj"sv, "an OBJ mesh", kMeshlab},
    KnownFormat{"off"sv, "an OFF mesh", kMeshlab},
    KnownFormat{"stl"sv, "an STL mesh", kMeshlab},
    KnownFormat{"drc"sv, "a Draco file", "; convert with: draco_decoder -i IN -o OUT.ply"},
    KnownFormat{"gltf"sv, "a glTF file", kMeshlab},
    KnownFormat{"glb"sv, "a glTF file", kMeshlab},
    KnownFormat{"dae"sv, "a Collada file", kMeshlab},
    KnownFormat{"3ds"sv, "a 3DS file", kMeshlab},
    KnownFormat{"wrl"sv, "a VRML file", kMeshlab},
    KnownFormat{"vtk"sv, "a VTK file", kMeshlab},
    KnownFormat{"vtp"sv, "a VTK file", kMeshlab},
};

/// Lower-case extension without the dot and without `.gz`.
std::string extension_of(const std::string& path) {
    std::string name = path.substr(path.rfind('/') + 1);
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (name.ends_with(".gz")) name.resize(name.size() - 3);
    const auto dot = name.rfind('.');
    return dot == std::string::npos ? "" : name.substr(dot + 1);
}

bool starts_as_ply(std::string_view head) {
    if (head.substr(0, 3) != "ply") return false;
    return head.size() > 3 && std::isspace(static_cast<unsigned char>(head[3]));
}

/// The advice with the file's own names in the command's places IN and OUT.ply.
std::string with_names(std::string advice, const std::string& path) {
    const auto slash = path.rfind('/'), dot = path.rfind('.');
    const bool has_extension =
        dot != std::string::npos && (slash == std::string::npos || dot > slash + 1) && dot > 0;
    const std::string out = (has_extension ? path.substr(0, dot) : path) + ".ply";
    for (const auto& [word, name] :
         {std::pair{std::string(" OUT.ply"), out}, std::pair{std::string(" IN"), path}})
        if (const auto at = advice.find(word); at != std::string::npos)
            advice.replace(at + 1, word.size() - 1, name);
    return advice;
}

[[noreturn]] void refuse(const std::string& path, const std::string& what, const char* advice) {
    throw FormatError(message(path, ": ", what, ": this format is not read; ", what_is_read(),
                              with_names(advice, path)));
}

bool is_control(char c) {
    const auto u = static_cast<unsigned char>(c);
    return u < 0x20 && c != '\n' && c != '\r' && c != '\t' && c != '\v' && c != '\f';
}

/// Text has no control characters but blanks and line ends.
void refuse_binary(const std::string& path, std::string_view head) {
    const auto hit = std::find_if(head.begin(), head.end(), is_control);
    if (hit == head.end()) return;
    refuse(path,
           message("byte ", hit - head.begin(), ": expected text, found the byte ",
                   static_cast<int>(static_cast<unsigned char>(*hit)), " of some binary format"),
           kNone);
}

}  // namespace

bool is_known_format(const std::string& path, std::string_view head) {
    const std::string extension = extension_of(path);
    if (starts_as_ply(head) || extension == "ply" || is_cloud_ending("." + extension)) return true;
    return std::any_of(kMagics.begin(), kMagics.end(),
                       [&](const KnownFormat& f) { return head.starts_with(f.key); }) ||
           std::any_of(kExtensions.begin(), kExtensions.end(),
                       [&](const KnownFormat& f) { return extension == f.key; });
}

CloudKind cloud_kind(const std::string& path, std::string_view head) {
    if (head.empty())
        throw FormatError(message(path, ": the file is empty (0 bytes); ", what_is_read()));
    if (starts_as_ply(head)) return CloudKind::ply;
    for (const KnownFormat& format : kMagics)
        if (head.starts_with(format.key)) refuse(path, format.name, format.advice);
    const std::string extension = extension_of(path);
    for (const KnownFormat& format : kExtensions)
        if (extension == format.key) refuse(path, format.name, format.advice);
    if (extension == "ply")
        throw FormatError(message(path,
                                  ": byte 0: expected a PLY header, its first line 'ply', found "
                                  "something else"));
    refuse_binary(path, head);
    return CloudKind::text;
}

}  // namespace slim
