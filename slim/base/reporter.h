#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace slim {

/// Where libraries say what they do; they never print themselves. The default says nothing.
class Reporter {
public:
    virtual ~Reporter() = default;
    virtual void info(const std::string& /*text*/) {}
    virtual void warn(const std::string& /*text*/) {}
    /// `done` of `total` units of `what`; cheap, may be called often, from one thread at a time.
    virtual void progress(std::string_view /*what*/, std::uint64_t /*done*/,
                          std::uint64_t /*total*/) {}
};

}  // namespace slim
