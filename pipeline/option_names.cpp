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

/// The field whose path begins the message; null if none does.
const Field* field_of_path(const FieldList& fields, const std::string& what) {
    for (const Field& field : fields.fields())
        if (field.is_path())
            for (const std::string& item : field.items())
                if (!item.empty() && (what.starts_with(item + ":") || what.starts_with(item + " ")))
                    return &field;
    return nullptr;
}

/// "-o x.txt: expected ..." of "x.txt: expected ...": which of several files it is of. Not where a
/// file's line follows, which says more.
std::string with_option_of_path(const Field& field, const std::string& what, bool in_a_job) {
    bool of_line = false;
    for (const std::string& item : field.items())
        of_line |= what.starts_with(item + ":") && what.size() > item.size() + 1 &&
                   what[item.size() + 1] >= '0' && what[item.size() + 1] <= '9';
    const bool is_output = field.role == FieldRole::output;
    if (field.is_word() || of_line || (is_output && in_a_job)) return what;
    return (is_output ? "-o" : field.option()) + " " + what;
}

}  // namespace

std::string quoted_key(std::string_view key) { return kMark + std::string(key) + kMark; }

std::string with_option_names(const FieldList& fields, std::string what, bool in_a_job) {
    what = without_marks(fields, what);
    const std::size_t end = what.find_first_of(": ");
    if (end == std::string::npos) return what;
    if (const Field* path = field_of_path(fields, what))
        return with_option_of_path(*path, what, in_a_job);
    const Field* field = fields.find(what.substr(0, end));
    return field && !field->is_word() ? field->option() + what.substr(end) : what;
}

}  // namespace slim
