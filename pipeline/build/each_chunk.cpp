#include "pipeline/build/each_chunk.h"

#include "slim/base/parallel.h"

#include <exception>
#include <filesystem>
#include <utility>

namespace slim {
namespace {

/// Progress in bytes over all files: the only measure that every format knows.
class ByteProgress {
public:
    ByteProgress(const std::vector<std::string>& paths, std::string doing, Reporter& reporter)
        : reporter_(reporter), doing_(std::move(doing)) {
        for (const std::string& path : paths) {
            std::error_code ignored;
            const auto size = std::filesystem::file_size(path, ignored);
            total_ += ignored ? 0 : size;
        }
    }
    void show(std::uint64_t in_file) { reporter_.progress(doing_, done_ + in_file, total_); }
    void finish_file(std::uint64_t size) { done_ += size; }

private:
    Reporter& reporter_;
    std::string doing_;
    std::uint64_t done_ = 0;
    std::uint64_t total_ = 0;
};

}  // namespace

void for_each_chunk(const std::vector<std::string>& paths, Reporter& reporter,
                    const std::string& doing,
                    const std::function<void(const PointChunk&, std::uint64_t, std::size_t,
                                             const CloudInfo&)>& take,
                    bool face_points,
                    const std::function<void(std::size_t, std::uint64_t)>& beside) {
    ByteProgress progress(paths, doing, reporter);
    PointChunk chunk, next;
    std::uint64_t first_id = 0;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const auto source = open_cloud(paths[i], face_points);
        bool more = source->read(chunk, kChunkPoints), after = false;
        while (true) {
            // The next chunk is read while this one is taken; what is wrong here comes first.
            std::exception_ptr unreadable;
            const auto read_next = [&] {
                try {
                    after = more && source->read(next, kChunkPoints);
                } catch (...) {
                    unreadable = std::current_exception();
                }
            };
            const auto take_this = [&] { take(chunk, first_id, i, source->info()); };
            const std::uint64_t n_bytes = source->bytes_read();
            run_both(read_next, [&] {
                if (!beside) return take_this();
                run_both(take_this, [&] { beside(i, n_bytes); });
            });
            if (unreadable) std::rethrow_exception(unreadable);
            if (!more) break;
            first_id += chunk.size();
            progress.show(source->bytes_read());
            std::swap(chunk, next);
            more = after;
        }
        progress.finish_file(source->info().file_size);
    }
}

}  // namespace slim
