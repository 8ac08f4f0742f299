#pragma once

#include "slim/base/error.h"
#include "slim/base/vec.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace slim {

/// One thing described in words: "KIND key=value key=value", as options that hold several of them
/// say it. Values are taken out one by one; what is left over is an unknown word. All throw
/// ConfigError beginning with `where`, the option and the description.
class WordList {
public:
    WordList(std::string where, const std::string& text, bool has_kind);

    const std::string& kind() const { return kind_; }
    bool has(std::string_view key) const;
    std::string text(const char* key, const std::string& otherwise);
    /// Takes the key out if it has just this value.
    bool takes(const char* key, std::string_view value);
    double number(const char* key, double otherwise, double min, double max);
    bool on_off(const char* key, bool otherwise);
    /// `word`: what else the key may be, which takes() took; for the message.
    Vec3f color(const char* key, const Vec3f& otherwise, const std::string& word = {});
    /// So many numbers; "a,b".
    std::vector<double> numbers(const char* key, std::size_t n, std::vector<double> otherwise);
    Vec3d vector(const char* key, const Vec3d& otherwise);
    /// Nothing is left; `known` are the keys there are.
    void finish() const;

    [[noreturn]] void fail(const std::string& why) const { fail(Fault{.problem = why}); }
    /// The option is its key, the description begins its problem.
    [[noreturn]] void fail(Fault fault) const;

private:
    std::string where_, text_, kind_;
    std::vector<std::pair<std::string, std::string>> words_;
    std::vector<std::string> known_;
};

/// The descriptions in "...; ...", blanks around them taken off; empty ones are left out.
std::vector<std::string> split_descriptions(const std::string& text);

}  // namespace slim
