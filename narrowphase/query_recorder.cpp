// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/query_file.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

fs::path file_of(const fs::path& prefix, ContactKind kind) {
  const std::string ending = std::string(query_kind_name(kind)) + ".csv";
  std::error_code error;
  if (fs::is_directory(prefix, error)) return prefix / ending;
  fs::path stem = prefix;
  if (stem.extension() == ".csv") stem.replace_extension();
  const fs::path folder = stem.parent_path();
  if (!stem.has_filename() || (!folder.empty() && !fs::is_directory(folder, error)))
    throw std::invalid_argument(prefix.string() +
                                ": there is no such folder to record queries in; create it first");
  return stem += "." + ending;
}

/// ccd_exact returns the largest double not later than the true time.
TimeEnclosure enclosure_of(double toi) {
  if (toi == kNoCollision) return {};
  return {toi, std::min(1.0, std::nextafter(toi, 2.0))};
}

}  // namespace

/// Every stride-th of the queries of one kind.
struct QueryRecorder::Sample {
  Sample(const fs::path& prefix, ContactKind of_kind)
      : kind(of_kind),
        file(file_of(prefix, of_kind)),
        writer(std::make_unique<QueryWriter>(file)) {}

  bool wants_next() { return asked++ % stride == 0; }

  void keep(const Query& query, std::size_t limit) {
    queries.push_back(query);
    if (limit == 0 || queries.size() <= limit) return;
    for (std::size_t i = 0; 2 * i < queries.size(); ++i) queries[i] = queries[2 * i];
    queries.resize((queries.size() + 1) / 2);
    stride *= 2;
  }

  ContactKind kind;
  fs::path file;
  std::unique_ptr<QueryWriter> writer;
  std::vector<Query> queries;
  std::size_t asked = 0, stride = 1;
};

QueryRecorder::QueryRecorder(const QueryRecorderConfig& config) : limit_(config.limit) {
  for (const ContactKind kind : {ContactKind::point_triangle, ContactKind::edge_edge})
    samples_.emplace_back(config.prefix, kind);
}

QueryRecorder::~QueryRecorder() = default;

QueryRecorder::Sample& QueryRecorder::sample_of(ContactKind kind) {
  return samples_[kind == ContactKind::edge_edge ? 1 : 0];
}

void QueryRecorder::add(const Query& query) {
  const std::lock_guard lock(mutex_);
  Sample& sample = sample_of(query.kind);
  if (sample.wants_next()) sample.keep(query, limit_);
}

void QueryRecorder::add(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto pair = detail::pair_at(a, b, pairs, i);
    Sample& sample = sample_of(pair.kind);
    if (sample.wants_next()) sample.keep(detail::query_of(a, b, pair), limit_);
  }
}

std::vector<RecordedQueries> QueryRecorder::write() {
  const std::unique_ptr<NarrowPhase> exact = make_ccd_exact();
  std::vector<RecordedQueries> recorded;
  for (Sample& sample : samples_) {
    if (sample.queries.empty()) {
      sample.writer.reset();
      std::error_code ignored;  // a missing file need not be removed
      fs::remove(sample.file, ignored);
      fs::remove(toi_file_of(sample.file), ignored);
      continue;
    }
    std::vector<double> toi(sample.queries.size());
    exact->find_times(sample.queries, toi);
    for (std::size_t i = 0; i < toi.size(); ++i)
      sample.writer->append(sample.queries[i], enclosure_of(toi[i]));
    sample.writer->commit();
    const auto misses = std::count(toi.begin(), toi.end(), kNoCollision);
    recorded.push_back(
        {sample.file, sample.asked, toi.size(), toi.size() - static_cast<std::size_t>(misses)});
  }
  return recorded;
}

namespace {

class Recording final : public NarrowPhase {
 public:
  Recording(std::unique_ptr<NarrowPhase> method, QueryRecorder& recorder)
      : method_(std::move(method)), recorder_(recorder) {}

  void find_times(std::span<const Query> queries, std::span<double> toi) const override {
    for (const Query& query : queries) recorder_.add(query);
    method_->find_times(queries, toi);
  }
  void find_contacts(const SurfaceView& a, const SurfaceView& b, const CandidatePairs& pairs,
                     std::vector<Contact>& out) const override {
    recorder_.add(a, b, pairs);
    method_->find_contacts(a, b, pairs, out);
  }
  NarrowPhaseTraits traits() const override { return method_->traits(); }

 private:
  std::unique_ptr<NarrowPhase> method_;
  QueryRecorder& recorder_;
};

}  // namespace

std::unique_ptr<NarrowPhase> make_recording(std::unique_ptr<NarrowPhase> method,
                                            QueryRecorder& recorder) {
  return std::make_unique<Recording>(std::move(method), recorder);
}

}  // namespace selvedge
