#include "pipeline/option_names.h"

#include <algorithm>

namespace slim {
namespace {

/// Unit separator, invisible where it is printed; no file's name has it.
constexpr char kMark = '\x1f';

/// Without marks: --key, or in backquotes as it was.
std::string without_marks(const FieldList& fields, const std::string& what) {
    std::string out;
    std::size_t at = 0;
    for (std::size_t mark; (mark = what.find(kMark, at)) != std::string::npos;) {
        const std::size_t close = std::min(what.find(kMark, mark + 1), what.size());
        const std::string key = what.substr(mark + 1, close - mark - 1);
        const Field* field = fields.find(key);
        out += what.substr(at, mark - at) +
               (field && !field->is_word() ? field->option() : "`" + key + "`");
        at = std::min(close + 1, what.size());
    }
    return out + what.substr(at);
}

bool begins_with_a_path(const FieldList& fields, const std::string& what) {
    for (const Field& field : fields.fields())
        if (field.is_path())
            for (const std::string& item : field.items())
                if (!item.empty() && (what.starts_with(item + ":") || what.starts_with(item + " ")))
                    return true;
    return false;
}

}  // namespace

std::string quoted_key(std::string_view key) { return kMark + std::string(key) + kMark; }

std::string with_option_names(const FieldList& fields, std::string what) {
    what = without_marks(fields, what);
    const std::size_t end = what.find_first_of(": ");
    if (end == std::string::npos || begins_with_a_path(fields, what)) return what;
    const Field* field = fields.find(what.substr(0, end));
    return field && !field->is_word() ? field->option() + what.substr(end) : what;
}

}  // namespace slim
