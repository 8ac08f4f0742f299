#include "pipeline/build/normals_settings.h"

#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>

namespace slim {
namespace {

std::set<std::string> lines_of(const std::string& text) {
    std::set<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.insert(line);
    return lines;
}

/// "--normals flip" of `normals = "flip"`
std::string as_option(const std::string& line) {
    const std::size_t at = line.find(" = ");
    if (at == std::string::npos) return line;
    std::string key = line.substr(0, at), value = line.substr(at + 3);
    std::replace(key.begin(), key.end(), '_', '-');
    std::erase(value, '"');
    return "--" + key + " " + value;
}

}  // namespace

void NormalsSettings::add(std::size_t slice, const std::string& settings) {
    if (!settings.empty()) slices_[settings].push_back(slice);
}

void NormalsSettings::add(std::size_t slice, const std::string& settings, const std::string& hash,
                          const std::string& file) {
    if (settings.empty()) return;
    const std::string line = "sensors = " + hash;
    sensors_.try_emplace(line, hash.empty()   ? "no sensors"
                               : file.empty() ? "the sensors beside its inputs"
                                              : "--sensors " + file);
    add(slice, settings + line + "\n");
}

void NormalsSettings::require_same(const std::string& work) const {
    if (slices_.size() < 2) return;
    std::set<std::string> common = lines_of(slices_.begin()->first);
    for (const auto& [settings, slices] : slices_) {
        const std::set<std::string> lines = lines_of(settings);
        std::erase_if(common, [&](const std::string& line) { return !lines.contains(line); });
    }
    std::string text;
    for (const auto& [settings, slices] : slices_) {
        text += fmt::format("{} slice{} {} with", text.empty() ? "" : ",",
                            slices.size() == 1 ? "" : "s", fmt::join(slices, " "));
        for (const std::string& line : lines_of(settings))
            if (!common.contains(line))
                text += " " + (sensors_.contains(line) ? sensors_.at(line) : as_option(line));
    }
    throw IncompleteError(fmt::format(
        "{}: the normals of its slices were made with different options:{}: run `slim normals {}` "
        "for all slices, with the same options",
        work, text, work));
}

}  // namespace slim
