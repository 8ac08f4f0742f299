#pragma once

#include <array>
#include <string>
#include <utility>

namespace slim {

/// Names that other programs write texts of a picture under, and ours, those of EXR.
inline constexpr std::array<std::pair<const char*, const char*>, 3> kPngNames{
    {{"Author", "Artist"}, {"Description", "ImageDescription"}, {"Title", "DocumentName"}}};

inline std::string name_in_png(const std::string& ours) {
    constexpr std::size_t kLongest = 79;  // by the format
    for (const auto& [png, name] : kPngNames)
        if (ours == name) return png;
    return ours.substr(0, kLongest);
}

inline std::string name_from_png(const std::string& theirs) {
    for (const auto& [png, name] : kPngNames)
        if (theirs == png) return name;
    return theirs;
}

}  // namespace slim
