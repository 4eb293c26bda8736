#include "trunnion/nc/write.hpp"

#include <cmath>

#include "detail/program_writer.hpp"

namespace trunnion::nc {

namespace {

/// A form of curves belongs to one dialect.
Result<void> check_curves(const WriteOptions& options) {
    const bool of_sinumerik = options.curves == CurveForm::bspline || options.curves == CurveForm::poly;
    const bool absent = (of_sinumerik && options.dialect != Dialect::sinumerik) ||
                        (options.curves == CurveForm::nurbs && options.dialect != Dialect::fanuc);
    if (!absent) return {};
    return fail({.code = "NC0908",
                 .text = "this form of curves is not of this dialect",
                 .value = std::string(name_of(options.dialect)),
                 .hint = "BSPLINE and POLY are of sinumerik, NURBS of fanuc; the others take points"});
}

Result<void> check(const WriteOptions& options) {
    for (const double precision :
         {options.precision_mm, options.precision_deg, options.vector_precision, options.feed_precision})
        if (!(precision >= 1e-12 && precision < 1))
            return fail({.code = "NC0901",
                         .text = "a precision of what is written lies between 1e-12 and 1",
                         .value = std::to_string(precision)});
    return check_curves(options);
}

Result<std::unique_ptr<ProgramWriter>> writer_of(const program::Program& program, const machine::Machine* machine,
                                                 const WriteOptions& options, const TextSink& sink) {
    switch (options.dialect) {
        case Dialect::apt:
            return make_apt_writer(program, machine, options, sink);
        case Dialect::sinumerik:
            return make_sinumerik_writer(program, machine, options, sink);
        case Dialect::heidenhain:
            return make_heidenhain_writer(program, machine, options, sink);
        case Dialect::fanuc:
            return make_fanuc_writer(program, machine, options, sink);
        case Dialect::rs274:
            break;
    }
    return make_rs274_writer(program, machine, options, sink);
}

}  // namespace

Result<WriteSummary> write_program(const program::Program& program, const machine::Machine* machine,
                                   const WriteOptions& options, const TextSink& sink) {
    if (auto good = check(options); !good) return fail(good.error());
    if (!program.surface_jobs.empty())
        return fail({.code = "NC0068",
                     .text = "surfaces are not written: their passes come first",
                     .hint = "pipeline::expand_surfaces lays them"});
    auto writer = writer_of(program, machine, options, sink);
    if (!writer) return fail(writer.error());
    return (*writer)->write();
}

Result<std::string> write_text(const program::Program& program, const machine::Machine* machine,
                               const WriteOptions& options) {
    std::string text;
    const TextSink append = [&text](std::string_view piece) { text += piece; };
    const auto written = write_program(program, machine, options, append);
    if (!written) return fail(written.error());
    return text;
}

}  // namespace trunnion::nc
