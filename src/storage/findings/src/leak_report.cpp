// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/leak_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "markup.hpp"
#include "pipescout/leak_store/leak_exports.hpp"
#include "pipescout/statistics/normal.hpp"
#include "report_figures.hpp"

namespace pipescout {
namespace {

using statistics::kNormal95;

using leak_findings::Finding;

constexpr const char* kStyle = R"(
body{font:15px/1.45 system-ui,sans-serif;color:#1d2329;background:#fff;margin:0 auto;
max-width:1080px;padding:1.2em}
h1{font-size:1.6em;margin:.2em 0}h2{font-size:1.2em;margin:1.6em 0 .5em;
border-bottom:1px solid #d5dade}h3{font-size:1.05em;margin:.2em 0 .5em}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:.3em .6em;border-bottom:1px solid #e3e7ea;vertical-align:top}
th{font-weight:600;background:#f4f6f7}td.n,th.n{text-align:right}
.scroll{overflow-x:auto}.note{color:#5a646d;font-size:.87em;margin:.3em 0}
.badge{color:#fff;border-radius:.7em;padding:.05em .6em;font-size:.9em;white-space:nowrap}
.finding{border:1px solid #d5dade;border-radius:6px;padding:.8em 1em;margin:0 0 1em;
display:grid;grid-template-columns:minmax(200px,340px) 1fr;gap:1em;page-break-inside:avoid}
.finding h3{grid-column:1/-1}.plot,.map{width:100%;height:auto}
.thumbnail{max-width:100%;height:auto}.picture .thumbnail{width:320px}
.pictures{display:flex;flex-wrap:wrap;gap:1em}.picture{width:320px}
.picture h3{overflow-wrap:anywhere}.problem{color:#a01030}pre{white-space:pre-wrap;margin:0;
font:inherit}svg text{font:11px system-ui,sans-serif;fill:#3a444c}svg text.title{font-weight:600}
svg text.name{font-size:13px;font-weight:600}.grid line{stroke:#e3e7ea}
polyline.pipe{fill:none;stroke:#9aa4ac;stroke-width:3}
.track{fill:none;stroke:#2a78b5;stroke-width:1.2;stroke-dasharray:5 4}
.pipe-mark{fill:none;stroke:#fff;stroke-width:1.2;stroke-dasharray:6 4}
.leak-mark{fill:none;stroke:#2dff6e;stroke-width:2.2}
@media(max-width:700px){.finding{grid-template-columns:1fr}}
)";

std::string cell(const std::string& text) {
  return "<td>" + text + "</td>";
}

std::string number_cell(const std::string& text) {
  return "<td class=\"n\">" + text + "</td>";
}

/// "12.3 (11.0 to 13.6)"
std::string with_interval(double value, const leak_findings::Interval& interval, int decimals) {
  std::string text = fixed(value, decimals);
  if (std::isfinite(interval.low) && std::isfinite(interval.high)) {
    text += " (" + fixed(interval.low, decimals) + " to " + fixed(interval.high, decimals) + ")";
  }
  return text;
}

std::string badge(const Finding& finding) {
  return "<span class=\"badge\" style=\"background:" + severity_colour(finding.severity) + "\">" +
         std::string(to_string(finding.severity)) + "</span>";
}

std::string time_text(double seconds) {
  const std::string iso = iso_time(seconds);
  return iso.empty() ? "-" : iso.substr(0, 10) + " " + iso.substr(11, 8);
}

std::string length_text(const Finding& f) {
  std::string text = fixed(f.length, 2);
  if (std::isfinite(f.length) && std::isfinite(f.length_deviation)) {
    text += " &#177; " + fixed(kNormal95 * f.length_deviation, 2);
  }
  return text;
}

/// Raised before cleared, then the worst, then the warmest.
std::vector<const ReportedFinding*> by_severity(const std::vector<ReportedFinding>& findings) {
  std::vector<const ReportedFinding*> order;
  for (const ReportedFinding& reported : findings) {
    order.push_back(&reported);
  }
  const auto rank = [](const ReportedFinding* r) {
    const Finding& f = r->finding;
    const double delta = std::isfinite(f.mean_delta) ? f.mean_delta : 0;
    return std::array<double, 4>{f.state == leak_findings::FindingState::kRaised ? 0.0 : 1.0,
                                 -static_cast<double>(f.severity), -delta,
                                 static_cast<double>(f.id)};
  };
  std::sort(order.begin(), order.end(),
            [&rank](const auto* a, const auto* b) { return rank(a) < rank(b); });
  return order;
}

std::string summary(const LeakReport& report) {
  std::array<std::size_t, 4> count{};
  std::size_t cleared = 0;
  for (const ReportedFinding& reported : report.findings) {
    if (reported.finding.state == leak_findings::FindingState::kRaised) {
      ++count.at(static_cast<std::size_t>(reported.finding.severity));
    } else {
      ++cleared;
    }
  }
  std::string html = "<p>";
  for (std::size_t i = count.size(); i-- > 0;) {
    const auto severity = static_cast<thermal::Severity>(i);
    html += "<span class=\"badge\" style=\"background:" + severity_colour(severity) + "\">" +
            std::to_string(count[i]) + " " + std::string(to_string(severity)) + "</span> ";
  }
  html += std::to_string(cleared) + " cleared. " + std::to_string(report.pictures_read) +
          " pictures read";
  html += report.pictures_failed == 0
              ? "."
              : ", <span class=\"problem\">" + std::to_string(report.pictures_failed) +
                    " could not be used</span>.";
  return html + "</p>" + (report.degrees.empty() ? "" : "<p>" + escaped(report.degrees) + "</p>");
}

std::string table(const std::vector<const ReportedFinding*>& findings) {
  if (findings.empty()) {
    return "<p>No finding.</p>";
  }
  std::string html =
      "<div class=\"scroll\"><table><tr><th class=\"n\">Leak</th><th>Severity</th><th>State</th>"
      "<th class=\"n\">Probability</th><th class=\"n\">Mean Delta-T / K (95 %)</th>"
      "<th class=\"n\">Peak / K (95 %)</th><th class=\"n\">Length / m</th>"
      "<th class=\"n\">Growth / K/h</th><th>First seen</th><th>Last seen</th>"
      "<th class=\"n\">Passes</th><th class=\"n\">Frames</th></tr>";
  for (const ReportedFinding* reported : findings) {
    const Finding& f = reported->finding;
    const std::string id = std::to_string(f.id);
    html += "<tr>" + number_cell("<a href=\"#leak" + id + "\">" + id + "</a>") + cell(badge(f)) +
            cell(std::string(to_string(f.state))) + number_cell(fixed(f.probability, 3)) +
            number_cell(with_interval(f.mean_delta, f.mean_delta_interval, 1)) +
            number_cell(with_interval(f.peak_delta, f.peak_delta_interval, 1)) +
            number_cell(length_text(f)) + number_cell(fixed(f.delta_growth, 2)) +
            cell(time_text(f.first_time)) + cell(time_text(f.last_time)) +
            number_cell(std::to_string(f.pass_count)) + number_cell(std::to_string(f.frames)) +
            "</tr>";
  }
  return html + "</table></div>";
}

std::string place_text(const Finding& f, const std::optional<geometry::GeodeticPosition>& datum) {
  if (!f.position || !f.position->point.allFinite()) {
    return "Position unknown.";
  }
  const Eigen::Vector3d& p = f.position->point;
  const Eigen::Vector3d deviation = f.position->covariance.diagonal().cwiseMax(0).cwiseSqrt();
  std::string text = "At (" + fixed(p.x(), 2) + ", " + fixed(p.y(), 2) + ", " + fixed(p.z(), 2) +
                     ") m in the map, &#177; (" + fixed(kNormal95 * deviation.x(), 2) + ", " +
                     fixed(kNormal95 * deviation.y(), 2) + ", " +
                     fixed(kNormal95 * deviation.z(), 2) + ") m.";
  if (datum) {
    const auto place = geometry::LocalFrame(*datum).geodetic(p);
    text += " WGS 84: " + fixed(place.latitude, 7) + ", " + fixed(place.longitude, 7) + ".";
  }
  return text;
}

std::string passes_text(const Finding& f) {
  if (f.passes.size() < 2) {
    return "";
  }
  std::string html =
      "<table><tr><th>Pass</th><th class=\"n\">Frames</th><th class=\"n\">Mean Delta-T / K</th>"
      "<th class=\"n\">Length / m</th></tr>";
  for (const leak_findings::PassSummary& pass : f.passes) {
    html += "<tr>" + cell(time_text(pass.time)) + number_cell(std::to_string(pass.frames)) +
            number_cell(fixed(pass.delta, 1) + " &#177; " +
                        fixed(kNormal95 * pass.delta_deviation, 1)) +
            number_cell(fixed(pass.length, 2)) + "</tr>";
  }
  return html + "</table>";
}

std::string finding_card(const ReportedFinding& reported,
                         const std::optional<geometry::GeodeticPosition>& datum) {
  const Finding& f = reported.finding;
  const std::string id = std::to_string(f.id);
  std::string html =
      "<article class=\"finding\" id=\"leak" + id + "\"><h3>Leak " + id + " " + badge(f) + "</h3>";
  if (!reported.evidence) {
    return html + "<div><p>" + place_text(f, datum) + "</p>" + passes_text(f) +
           "</div><div><p>Without an image.</p></div></article>";
  }
  const Evidence& e = *reported.evidence;
  html += "<div>" + thumbnail_figure(e.thumbnail, {e.pipe}, {e.leak}, "Leak " + id) +
          "<p class=\"note\">" + escaped(e.source) + ", " + time_text(e.time) + ". Colours from " +
          fixed(e.thumbnail.coldest, 1) + " to " + fixed(e.thumbnail.hottest, 1) +
          " degC. White: pipe. Green: leak.</p><p>" + place_text(f, datum) + "</p>" +
          passes_text(f) + "</div><div>" + profile_figure(e) + "</div></article>";
  return html;
}

std::string log(const std::vector<ConditionRecord>& conditions) {
  if (conditions.empty()) {
    return "<p>No entries.</p>";
  }
  std::string html =
      "<div class=\"scroll\"><table><tr><th>From</th><th>Source</th><th>Camera</th>"
      "<th>Emissivity, distances, air</th><th>Weather</th><th>Calibration</th><th>Implausible</th>"
      "</tr>";
  for (const ConditionRecord& c : conditions) {
    const auto text = [](const std::string& value) {
      return cell(value.empty() ? "-" : "<pre>" + escaped(value) + "</pre>");
    };
    html += "<tr>" + cell(time_text(c.time)) + text(c.source) + text(c.camera) +
            text(c.parameters) + text(c.weather) + text(c.calibration) + text(c.doubts) + "</tr>";
  }
  return html + "</table></div>";
}

std::string pictures(const std::vector<ReportedPicture>& shown) {
  if (shown.empty()) {
    return "";
  }
  std::string html = "<h2>Images</h2><div class=\"pictures\">";
  for (const ReportedPicture& p : shown) {
    html += "<div class=\"picture\"><h3>" + escaped(p.name) + "</h3>";
    if (p.overview) {
      html += thumbnail_figure(p.overview->thumbnail, p.overview->pipes, p.overview->leaks, p.name);
      html += "<p class=\"note\">Colours from " + fixed(p.overview->thumbnail.coldest, 1) + " to " +
              fixed(p.overview->thumbnail.hottest, 1) + " degC.</p>";
    }
    if (!p.problem.empty()) {
      html += "<p class=\"problem\">" + escaped(p.problem) + "</p>";
    }
    html += "<p>" + escaped(p.summary) + "</p>";
    if (!p.doubts.empty()) {
      html +=
          "<p class=\"note\">Implausible:</p><pre class=\"note\">" + escaped(p.doubts) + "</pre>";
    }
    html += "</div>";
  }
  return html + "</div>";
}

}  // namespace

std::string degrees_text(const thermal::RadiometryPosterior* posterior, bool levels) {
  if (levels) {
    return "Images with automatic gain: leaks are found by contrast, and nothing is told in "
           "degrees.";
  }
  if (posterior == nullptr || posterior->images() == 0) {
    return "";
  }
  const auto with_95 = [](const thermal::TemperatureInterval& value, int decimals) {
    return fixed(value.mean, decimals) + " (" + fixed(value.low, decimals) + " to " +
           fixed(value.high, decimals) + ")";
  };
  std::string text = "Leaks are found by contrast. Degrees, with their 95 % intervals, from " +
                     std::to_string(posterior->images()) + " images: sound pipe " +
                     with_95(posterior->pipe_temperature(), 0) + " degC, emissivity " +
                     with_95(posterior->emissivity(), 3) + ", reflected " +
                     with_95(posterior->reflected_temperature(), 1) + " degC.";
  if (posterior->contradicted()) {
    text +=
        " What is told of emissivity, reflected temperature and air gives the pipe no temperature "
        "that it may have: one of them, or its deviation, is wrong.";
  }
  return text;
}

std::string leak_report_html(const LeakReport& report) {
  const auto order = by_severity(report.findings);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
      escaped(report.title) + "</title><style>" + kStyle + "</style></head>\n<body>\n<h1>" +
      escaped(report.title) + "</h1><p class=\"note\">" + escaped(report.made) +
      ". Times are UTC.</p>\n" + summary(report) + "\n<h2>Map</h2>\n" + map_figure(report) +
      "\n<h2>Findings by severity</h2>\n" + table(order) + "\n";
  if (!order.empty()) {
    html += "<h2>Each finding</h2>\n";
    for (const ReportedFinding* reported : order) {
      html += finding_card(*reported, report.datum) + "\n";
    }
  }
  html += "<h2>Camera and conditions</h2>\n" + log(report.conditions) + "\n" +
          pictures(report.pictures);
  return html + "\n</body></html>\n";
}

}  // namespace pipescout
