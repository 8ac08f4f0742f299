#include "formats/extension.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace slim {

std::string lower_extension(const std::string& path) {
    std::string text = std::filesystem::path(path).extension().string();
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

}  // namespace slim
