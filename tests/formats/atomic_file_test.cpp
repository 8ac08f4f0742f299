#include "formats/atomic_file.h"

#include "formats/made_folders.h"
#include "tests/formats/file_support.h"

#include <csignal>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fcntl.h>
#include <malloc.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace slim::test {
namespace {

/// The number of a process that has ended.
pid_t dead_process() {
    const pid_t pid = ::fork();
    if (pid == 0) ::_exit(0);
    ::waitpid(pid, nullptr, 0);
    return pid;
}

/// What a process leaves of a file if it is killed; "host" is the name and the space of numbers.
std::string left_by(const std::string& file, const std::string& host, pid_t pid) {
    return file + ".tmp." + host + "." + std::to_string(pid) + ".0123abcd";
}

std::string this_host() {
    char host[256] = {};
    ::gethostname(host, sizeof host - 1);
    return host;
}

std::string this_place(unsigned long more = 0) {
    struct stat space {};
    if (::stat("/proc/self/ns/pid", &space) != 0) return this_host() + ".0";
    return this_host() + "." + std::to_string(space.st_ino + more);
}

TEST(AtomicFile, RemovesWhatDeadProcessesOfThisHostLeftOfItsName) {
    const TempFolder folder;
    const pid_t dead = dead_process();
    const std::string gone = folder.write(left_by("a", this_place(), dead), "half");
    const std::string locked = folder.write(left_by("a", this_place(), dead + 1000000), "half");
    const int holder = ::open(locked.c_str(), O_RDWR);
    ASSERT_EQ(::flock(holder, LOCK_EX), 0);  // as one on another host of this name does
    std::vector<std::string> stay = {locked};
    for (const std::string& name :
         {left_by("a", this_place(), ::getppid()), left_by("a", this_place(), ::getpid()),
          left_by("a", "other.1", dead), left_by("a", this_place(1), dead),
          left_by("a", this_host(), dead), left_by("b", this_place(), dead),
          left_by("a", this_place(), dead) + "e", std::string("a.tmp.") + this_place() + ".notes"})
        stay.push_back(folder.write(name, "of others"));
    write_file_atomically(folder.file("a"), "whole");
    EXPECT_FALSE(std::filesystem::exists(gone));
    for (const std::string& path : stay) EXPECT_TRUE(std::filesystem::exists(path)) << path;
    EXPECT_EQ(read_bytes(folder.file("a")), "whole");
    ::close(holder);
}

TEST(AtomicFile, MakesItsFolderWhichGoesAgainIfNothingIsWrittenThere) {
    const TempFolder folder;
    const std::string kept = folder.file("kept/deep/a"), not_kept = folder.file("new/deep/a");
    write_file_atomically(kept, "whole");
    { AtomicFile never_committed(not_kept); }
    EXPECT_TRUE(std::filesystem::exists(folder.file("new/deep")));
    remove_empty_made_folders();
    EXPECT_FALSE(std::filesystem::exists(folder.file("new")));
    EXPECT_EQ(read_bytes(kept), "whole");
    std::filesystem::create_directory(folder.file("empty"));  // not by make_folders
    make_folders(folder.file("empty"));
    remove_empty_made_folders();
    EXPECT_TRUE(std::filesystem::exists(folder.file("empty")));
}

TEST(AtomicFile, IsInvisibleUntilCommitted) {
    const TempFolder folder;
    const std::string path = folder.write("a", "old");
    {
        AtomicFile file(path);
        file.write("new");
        EXPECT_EQ(read_bytes(path), "old");
    }
    EXPECT_EQ(read_bytes(path), "old");
    EXPECT_EQ(folder.n_files(), 1u);
    AtomicFile file(path);
    file.write("hallo world");
    file.write_at(1, "e", 1);
    file.write("!");
    EXPECT_EQ(file.size(), 12u);
    file.commit();
    EXPECT_EQ(read_bytes(path), "hello world!");
    EXPECT_EQ(folder.n_files(), 1u);
}

TEST(AtomicFile, SealedItIsWholeButStillInvisible) {
    const TempFolder folder;
    const std::string path = folder.write("a", "old");
    {
        AtomicFile file(path);
        file.write("new");
        file.seal();
        EXPECT_EQ(read_bytes(path), "old");
        EXPECT_EQ(read_bytes(path + temporary_suffix()), "new");
    }
    EXPECT_EQ(folder.n_files(), 1u);
    AtomicFile file(path);
    file.write("new");
    file.seal();
    file.commit();
    EXPECT_EQ(read_bytes(path), "new");
    EXPECT_EQ(folder.n_files(), 1u);
}

TEST(AtomicFile, TemporariesOfAProcessThatEndsAreRemovedSealedOnesToo) {
    const TempFolder folder;
    AtomicFile open(folder.file("a")), sealed(folder.file("b")), done(folder.file("c"));
    open.write("a");
    sealed.write("b");
    sealed.seal();
    done.write("c");
    done.commit();
    EXPECT_EQ(folder.n_files(), 3u);
    remove_live_temporaries();
    EXPECT_EQ(folder.n_files(), 1u);
    EXPECT_EQ(read_bytes(folder.file("c")), "c");
}

TEST(AtomicFile, ReplacesFilesOnly) {
    const TempFolder folder;
    for (const std::string& path : {std::string("/dev/null"), folder.file(".")}) {
        try {
            AtomicFile file(path);
            FAIL() << path;
        } catch (const IoError& e) {
            EXPECT_EQ(e.code(), ExitCode::usage);
            EXPECT_NE(std::string(e.what()).find("is a "), std::string::npos);
        }
    }
}

TEST(AtomicFile, TemporaryNamesDifferBetweenHostsAndContainers) {
    const TempFolder folder;
    AtomicFile file(folder.file("a"));
    EXPECT_TRUE(std::filesystem::exists(folder.file("a") + temporary_suffix()));
    EXPECT_TRUE(temporary_suffix().starts_with(".tmp." + this_place() + "." +
                                               std::to_string(getpid()) + "."));
}

/// While it lives a file of this process may have 1000 bytes: more fails as on a full disk.
class FullDisk {
public:
    FullDisk() : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit small{1000, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &small);
    }
    ~FullDisk() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, old_handler_);
    }

private:
    rlimit before_{};
    void (*old_handler_)(int);
};

TEST(AtomicFile, AFailureThatALibrarySwallowedIsNotCommitted) {
    const TempFolder folder;
    AtomicFile file(folder.file("a"));
    {
        const FullDisk full;
        EXPECT_THROW(file.write_at(2000, "x", 1), IoError);
    }
    file.write("the rest is written");
    EXPECT_THROW(file.seal(), IoError);
    EXPECT_THROW(file.commit(), IoError);
    EXPECT_FALSE(std::filesystem::exists(folder.file("a")));
}

TEST(AtomicFile, AFullDiskIsAResourceErrorAndLeavesNothing) {
    const TempFolder folder;
    ExitCode code = ExitCode::ok;
    std::string said;
    try {
        const FullDisk full;
        write_file_atomically(folder.file("big"), std::string(5000, 'x'));
    } catch (const IoError& error) {
        code = error.code();
        said = error.what();
    }
    EXPECT_EQ(code, ExitCode::resource);
    EXPECT_NE(said.find("byte 1000: cannot be written: File too large (see `ulimit -f`)"),
              std::string::npos)
        << said;
    EXPECT_EQ(folder.n_files(), 0u);
    try {
        write_file_atomically(folder.write("file", "") + "/inside/a", "x");
        ADD_FAILURE();
    } catch (const IoError& error) {
        EXPECT_EQ(error.code(), ExitCode::usage);
    }
}

TEST(AtomicFile, HoldsNoMemoryOnceItIsSealed) {
    const TempFolder folder;
    std::vector<std::unique_ptr<AtomicFile>> held;
    const auto in_use = [] {
        const struct mallinfo2 m = mallinfo2();
        return m.uordblks + m.hblkhd;
    };
    const std::size_t before = in_use();
    for (int i = 0; i < 50; ++i) {
        held.push_back(std::make_unique<AtomicFile>(folder.file(std::to_string(i))));
        held.back()->write("a picture");
        held.back()->seal();
    }
    EXPECT_LT(in_use() - before, std::size_t{1} << 20);  // 50 MiB of buffers before
    for (auto& file : held) file->commit();
    EXPECT_EQ(read_bytes(folder.file("49")), "a picture");
}

}  // namespace
}  // namespace slim::test
