#include "pipeline/html_page.h"

#include "slim/base/markup.h"

namespace slim {
namespace {

constexpr const char* kStyle =
    R"(body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 78rem; padding: 0 1rem;
       color: #222; background: #fafafa }
h1 { margin-bottom: 0 }
p.note, figcaption { color: #555; font-size: .9rem }
table { border-collapse: collapse; margin: .6rem 0 }
th, td { text-align: right; padding: .25rem .9rem; border-bottom: 1px solid #ddd }
th:first-child, td:first-child { text-align: left }
figure { margin: 0; background: #fff; border: 1px solid #ddd; border-radius: 4px; padding: .5rem }
)";

}  // namespace

std::string html_head(const std::string& title, const std::string& style) {
    return R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>)" + escaped_markup(title) +
           "</title>\n<style>\n" + kStyle + style + "</style>\n</head>\n<body>\n";
}

}  // namespace slim
