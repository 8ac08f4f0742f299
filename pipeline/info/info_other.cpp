#include "pipeline/info/info_other.h"

#include "formats/extension.h"
#include "formats/image_io.h"
#include "formats/truth_file.h"
#include "pipeline/info/info_table.h"
#include "pipeline/info/info_toml.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json kind_info(const std::string& path, const char* kind, const std::string& about) {
    return {{"kind", kind}, {"bytes", fs::file_size(path)}, {"about", about}};
}

json picture_info(const std::string& path, const char* kind, int width, int height,
                  const json& channels, const ImageMetadata& metadata) {
    const bool is_ours = metadata.contains("slim:tree");
    json out = kind_info(path, kind,
                         is_ours ? "a picture of `slim render`; metadata says of what and how"
                                 : "a picture, not of `slim render`");
    out["width"] = width, out["height"] = height;
    out["channels"] = channels;
    out["metadata"] = json::object();
    for (const auto& [name, value] : metadata) out["metadata"][name] = value;
    return out;
}

json png_info(const std::string& path) {
    const PngReader reader(path);
    const PngImage& h = reader.header();
    json channels = h.n_file_channels >= 3 ? json{"R", "G", "B"} : json{"Y"};
    if (h.n_file_channels % 2 == 0) channels.push_back("A");
    return picture_info(path, "png", h.width, h.height, channels, h.metadata);
}

json exr_info(const std::string& path) {
    const ExrReader reader(path);
    json channels = json::array();
    for (const auto& [name, channel] : reader.header().channels) channels.push_back(name);
    return picture_info(path, "exr", reader.header().width, reader.header().height, channels,
                        reader.header().metadata);
}

json truth_info(const std::string& path) {
    TruthReader reader(path);
    json out = kind_info(path, "truth",
                         "exact normals and curvatures of a cloud's points: five little-endian "
                         "doubles a point, nx ny nz k1 k2, in the order of its file");
    out["points"] = reader.n_points();
    for (const char* ending : {".ply", ".ply.gz", ".xyz"}) {
        const std::string cloud = fs::path(path).replace_extension(ending).string();
        if (fs::exists(cloud)) out["cloud"] = cloud;
    }
    std::vector<PointTruth> part;
    for (std::uint64_t first = 0; reader.n_left() > 0; first += part.size()) {
        reader.read(std::min<std::uint64_t>(reader.n_left(), 1 << 16), path, part);
        check_truth(part, first, path);
    }
    return out;
}

/// How often any of the words stands in a text.
std::uint64_t count_in(const std::string& text, std::initializer_list<std::string_view> words) {
    std::uint64_t n = 0;
    for (const std::string_view word : words)
        for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; ++at) ++n;
    return n;
}

std::string whole_text(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return std::move(text).str();
}

/// How many elements of these names a text has: <line is not the beginning of <linearGradient.
std::uint64_t count_elements(const std::string& text,
                             std::initializer_list<std::string_view> names) {
    constexpr std::string_view kAfterName = " \t\r\n/>";
    std::uint64_t n = 0;
    for (const std::string_view name : names)
        for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) {
            if (text.compare(++at, name.size(), name) != 0) continue;
            const std::size_t end = at + name.size();
            n += end < text.size() && kAfterName.find(text[end]) != std::string_view::npos;
        }
    return n;
}

json svg_info(const std::string& path) {
    const std::string text = whole_text(path);
    const auto counted = [&](json out) {
        out["paths"] = count_elements(text, {"path", "polyline", "line"});
        out["texts"] = count_elements(text, {"text"});
        return out;
    };
    static const std::pair<const char*, const char*> kDrawings[] = {
        {".lines.svg", "feature lines of a picture of `slim render`, a drawing in millimetres"},
        {".contours.svg", "contour lines of a relief of `slim render`, a drawing in millimetres"},
        {".legend.svg", "the legend of a map of `slim render`"}};
    for (const auto& [ending, about] : kDrawings)
        if (path.ends_with(ending)) return counted(kind_info(path, "svg", about));
    return counted(kind_info(path, "svg", "a drawing (SVG)"));
}

json html_info(const std::string& path) {
    json out =
        kind_info(path, "html", "a page for a browser, as 'slim run' and 'slim report' write");
    const std::string text = whole_text(path);
    out["html_tables"] = count_elements(text, {"table"});
    out["pictures"] = count_elements(text, {"img"});
    out["plots"] = count_elements(text, {"svg"});
    return out;
}

json obj_info(const std::string& path) {
    std::ifstream in(path);
    std::string line;
    std::uint64_t vertices = 0, lines = 0, faces = 0;
    bool is_ours = false;
    while (std::getline(in, line)) {
        is_ours = is_ours || line.starts_with("# slim origin");
        vertices += line.starts_with("v "), lines += line.starts_with("l "),
            faces += line.starts_with("f ");
    }
    json out = kind_info(path, "obj",
                         is_ours ? "lines in space, as 'slim render --lines-obj' writes"
                         : faces > 0
                             ? "a mesh (OBJ), which is not read: write it as PLY"
                             : "points or lines (OBJ), which are not read: write them as PLY");
    out["vertices"] = vertices, out["lines"] = lines, out["faces"] = faces;
    return out;
}

/// What `slim plan` printed: by the comment that begins it, whatever the file is called.
std::optional<json> plan_info(const std::string& path) {
    struct Format {
        const char *name, *about, *counted;
        std::string_view mark, item;
    };
    static constexpr Format kFormats[] = {
        {"make", "a Makefile, printed by 'slim plan': 'make -f FILE' does the job", "rules",
         "# A Makefile for GNU make, made by 'slim plan", "\n\t'"},
        {"make", "the slices' part of a Makefile, printed by 'slim plan'", "rules",
         "# The slices of ", "\n\t'"},
        {"slurm", "a script that submits a job's steps to Slurm, printed by 'slim plan'", "jobs",
         "#!/bin/sh\n# Submits what 'slim run' does", "\nsubmit "},
        {"snakemake", "a Snakefile, printed by 'slim plan': 'snakemake -s FILE' does the job",
         "rules", "# A Snakefile, made by 'slim plan", "\nrule "}};
    std::ifstream in(path, std::ios::binary);
    std::string head(64, '\0');
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    for (const Format& format : kFormats) {
        if (!head.starts_with(format.mark)) continue;
        json out = kind_info(path, "workflow", format.about);
        out["format"] = format.name;
        out[format.counted] = count_in(whole_text(path), {format.item});
        return out;
    }
    return std::nullopt;
}

json log_info(const std::string& path) {
    json out = kind_info(path, "log", "what a program said (stderr), as of a report's step");
    const std::string text = whole_text(path);
    out["lines"] = count_in(text, {"\n"});
    out["warnings"] = count_in(text, {": warning: "});
    out["errors"] = count_in(text, {": error: "});
    return out;
}

json mark_info(const std::string& path) {
    return kind_info(path, "mark",
                     "of a folder that is a build's own, which removes it when its model is done");
}

}  // namespace

std::optional<json> other_info(const std::string& path) {
    std::error_code none;
    if (!fs::is_regular_file(path, none)) return std::nullopt;
    if (auto plan = plan_info(path)) return plan;
    if (fs::path(path).filename() == "made_by_slim_build") return mark_info(path);
    if (lower_extension(path) == ".csv") return table_info(path);
    static const std::map<std::string, std::function<json(const std::string&)>> kReaders = {
        {".png", png_info},   {".exr", exr_info},   {".truth", truth_info}, {".svg", svg_info},
        {".toml", toml_info}, {".html", html_info}, {".obj", obj_info},
        {".log", log_info}};
    const auto reader = kReaders.find(lower_extension(path));
    if (reader == kReaders.end()) return std::nullopt;
    return reader->second(path);
}

}  // namespace slim
