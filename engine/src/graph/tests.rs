use super::*;
use ash::vk;
use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};

struct Nothing;

impl Pass<()> for Nothing {
    fn record(&self, _: vk::CommandBuffer, (): &()) {}
}

fn after(accesses: &[Access]) -> History {
    accesses.iter().fold(History::default(), |history, access| dependency(history, *access).1)
}

#[test]
fn the_first_access_needs_no_barrier() {
    for access in [Access::ColorWrite, Access::ComputeRead, Access::ComputeReadWrite] {
        assert_eq!(dependency(History::default(), access).0, None);
    }
}

#[test]
fn a_read_waits_for_the_write_once() {
    let history = after(&[Access::ComputeWrite]);
    let (first, history) = dependency(history, Access::FragmentRead);
    let expected = Dependency {
        src_stages: S::COMPUTE_SHADER,
        src_access: A::SHADER_WRITE,
        dst_stages: S::FRAGMENT_SHADER,
        dst_access: A::SHADER_READ,
    };
    assert_eq!(first, Some(expected));
    let (second, history) = dependency(history, Access::FragmentRead);
    assert_eq!(second, None, "the same stage sees it already");
    let (third, _) = dependency(history, Access::ComputeRead);
    assert_eq!(third.map(|barrier| barrier.dst_stages), Some(S::COMPUTE_SHADER), "another stage does not");
}

#[test]
fn a_write_waits_for_all_readers_and_the_last_write() {
    let history = after(&[Access::ColorWrite, Access::ComputeRead, Access::FragmentRead]);
    let (needed, _) = dependency(history, Access::ColorWrite);
    let needed = needed.expect("a write after reads needs a barrier");
    assert_eq!(needed.src_stages, S::COLOR_ATTACHMENT_OUTPUT | S::COMPUTE_SHADER | S::FRAGMENT_SHADER);
    assert_eq!(needed.src_access, A::COLOR_ATTACHMENT_WRITE, "reads need no memory dependency");
}

#[test]
fn a_write_after_reads_alone_waits_for_execution_only() {
    let history = after(&[Access::ComputeRead]);
    let (needed, _) = dependency(history, Access::ComputeWrite);
    let needed = needed.expect("write after read");
    assert_eq!((needed.src_stages, needed.src_access), (S::COMPUTE_SHADER, A::NONE));
}

fn example() -> Graph<()> {
    let mut graph = Graph::default();
    let scene = graph.input("scene");
    let gbuffer = graph.resource("gbuffer");
    let unused = graph.resource("motion");
    let hdr = graph.resource("hdr");
    graph.pass("gbuffer", &[(scene, Access::VertexRead), (gbuffer, Access::ColorWrite)], Nothing);
    graph.pass("motion", &[(gbuffer, Access::ComputeRead), (unused, Access::ComputeWrite)], Nothing);
    graph.pass("shade", &[(gbuffer, Access::ComputeRead), (hdr, Access::ComputeWrite)], Nothing);
    graph.output(hdr);
    graph
}

#[test]
fn the_plan_prints_itself() {
    let plan = example().bake().expect("valid");
    let expected = "\
inputs: scene
outputs: hdr
   barrier COLOR_ATTACHMENT_OUTPUT | COMPUTE_SHADER (COLOR_ATTACHMENT_WRITE) -> COLOR_ATTACHMENT_OUTPUT (COLOR_ATTACHMENT_WRITE)
 1 gbuffer: reads scene; writes gbuffer
   barrier COMPUTE_SHADER | COLOR_ATTACHMENT_OUTPUT (SHADER_WRITE | COLOR_ATTACHMENT_WRITE) -> COMPUTE_SHADER (SHADER_READ | SHADER_WRITE)
 2 shade: reads gbuffer; writes hdr
not recorded, since nothing reads what they write: motion
";
    let normal = |text: &str| {
        // The order in which flags are printed is not ours to fix.
        let mut words: Vec<_> = text.split([' ', '\n']).filter(|word| !word.is_empty() && *word != "|").map(str::to_owned).collect();
        words.iter_mut().for_each(|word| *word = word.trim_matches(['(', ')']).to_owned());
        words.sort();
        words
    };
    assert_eq!(normal(&plan.to_string()), normal(expected), "{plan}");
    let names: Vec<_> = plan.steps().iter().map(PlanStep::name).collect();
    assert_eq!(names, ["gbuffer", "shade"]);
}

#[test]
fn mistakes_are_found_before_anything_runs() {
    let mut graph = Graph::default();
    let a = graph.resource("a");
    graph.pass("reader", &[(a, Access::ComputeRead)], Nothing);
    let error = graph.bake().err().map(|error| error.to_string());
    assert_eq!(error.as_deref(), Some("pass reader reads a, which nothing has written before it"));

    let mut graph: Graph<()> = Graph::default();
    let a = graph.resource("a");
    graph.output(a);
    assert_eq!(graph.bake().err(), Some(GraphError::OutputNotWritten { resource: "a".into() }));

    let mut graph = Graph::default();
    let a = graph.input("a");
    graph.pass("twice", &[(a, Access::ComputeRead), (a, Access::ComputeWrite)], Nothing);
    let error = GraphError::DeclaredTwice { pass: "twice", resource: "a".into() };
    assert_eq!(graph.bake().err(), Some(error));
}
