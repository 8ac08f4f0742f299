#pragma once

#include <string>

namespace slim {

/// A page up to and with <body>: the title (plain text) and the looks that all pages share, then
/// those of this one (CSS). Nothing is fetched from elsewhere.
std::string html_head(const std::string& title, const std::string& style);

inline constexpr const char* kHtmlEnd = "</body>\n</html>\n";

}  // namespace slim
