#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace slim {

/// Notices that a cloud changed between two readings of it.
class InputWatch {
public:
    explicit InputWatch(std::vector<std::string> paths);
    /// throws DataError naming the file whose size or time of change is another than at the start
    void check() const;
    /// Does the work and checks, also when the work throws: what it says then is only a
    /// consequence.
    template <class Work>
    void over(Work&& work) const {
        try {
            work();
        } catch (const std::exception&) {
            check();
            throw;
        }
        check();
    }

private:
    using State = std::pair<std::uintmax_t, std::filesystem::file_time_type>;
    std::vector<std::string> paths_;
    std::vector<State> states_;
};

}  // namespace slim
