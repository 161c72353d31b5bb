//! gRPC from outside: what a client in any language would see.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test fails by a panic")]

use std::time::Duration;

use futures::StreamExt;
use prost::Message;
use takt::grpc::proto::job_event::Kind;
use takt::grpc::proto::planning_service_client::PlanningServiceClient;
use takt::grpc::proto::robot_service_client::RobotServiceClient;
use takt::grpc::proto::{
    self, CancelJobRequest, GetJobRequest, GetResultRequest, JobEvent, JobState, ListJobsRequest,
    ResultChunk, WatchJobRequest,
};
use takt::grpc::{ERROR_DOMAIN, join};
use tonic::codec::CompressionEncoding;
use tonic::transport::Channel;
use tonic::{Code, Request, Status};
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_check_response::ServingStatus;
use tonic_health::pb::health_client::HealthClient;
use tonic_reflection::pb::{v1, v1alpha};
use tonic_types::StatusExt;

use crate::grpc_support::{
    ENDLESS, FAILS, LARGE, PROGRESS_EVENTS, SUCCEEDS, Server, job_request, result, robot,
};

async fn events(
    client: &mut PlanningServiceClient<Channel>,
    id: &str,
    after_seq: u64,
) -> Vec<JobEvent> {
    let request = WatchJobRequest { id: id.to_owned(), after_seq };
    let events = client.watch_job(request).await.unwrap().into_inner();
    events.map(Result::unwrap).collect().await
}

async fn chunks(
    client: &mut PlanningServiceClient<Channel>,
    request: GetResultRequest,
) -> Result<Vec<ResultChunk>, Status> {
    let chunks = client.get_result(request).await?.into_inner();
    Ok(chunks.map(Result::unwrap).collect().await)
}

fn whole(id: &str) -> GetResultRequest {
    GetResultRequest { id: id.to_owned(), partial: false }
}

/// The stable name of a refusal.
fn reason(status: &Status) -> String {
    let details = status.get_error_details();
    let info = details.error_info().expect("every refusal carries an ErrorInfo");
    assert_eq!(info.domain, ERROR_DOMAIN);
    info.reason.clone()
}

#[tokio::test]
async fn a_job_is_created_watched_and_fetched() {
    let server = Server::start().await;
    let mut client = server.planning().await;
    let mut request = job_request(SUCCEEDS);
    request.priority = Some(70);
    request.labels.insert("cell".to_owned(), "3".to_owned());
    let job = client.create_job(request).await.unwrap().into_inner();
    assert_eq!((job.priority, job.task.as_str(), job.seed), (70, "waypoints", SUCCEEDS));

    let all = events(&mut client, &job.id, 0).await;
    let seqs: Vec<_> = all.iter().map(|event| event.seq).collect();
    assert_eq!(seqs, (1..=3 + PROGRESS_EVENTS).collect::<Vec<_>>());
    let Some(Kind::State(queued)) = &all[0].kind else { panic!("{:?}", all[0]) };
    assert_eq!(queued.state(), JobState::Queued);
    let Some(Kind::Progress(progress)) = &all[2].kind else { panic!("{:?}", all[2]) };
    assert_eq!((progress.iteration, progress.best, progress.mean), (1, Some(2.5), None));
    let Some(Kind::Finished(finished)) = &all[3].kind else { panic!("{:?}", all[3]) };
    assert_eq!(finished.state(), JobState::Succeeded);
    assert_eq!(finished.summary.as_ref().unwrap().duration, Some(2.0));
    // Who comes late or again sees the same.
    assert_eq!(events(&mut client, &job.id, 2).await, all[2..]);
    assert_eq!(events(&mut client, &job.id, 99).await, []);

    let chunks = chunks(&mut client, whole(&job.id)).await.unwrap();
    assert_eq!(chunks.len(), 1);
    assert_eq!(join(chunks).unwrap(), result(SUCCEEDS));

    let request = GetJobRequest { id: job.id.clone() };
    let ended = client.get_job(request).await.unwrap().into_inner();
    assert_eq!((ended.state(), ended.attempt), (JobState::Succeeded, 1));
    assert_eq!(ended.created_at, job.created_at);
}

#[tokio::test]
async fn jobs_are_listed_by_state_and_label_in_pages() {
    let server = Server::start().await;
    let mut client = server.planning().await;
    let mut ids = Vec::new();
    for cell in ["1", "2", "1"] {
        let mut request = job_request(SUCCEEDS);
        request.labels.insert("cell".to_owned(), cell.to_owned());
        let id = client.create_job(request).await.unwrap().into_inner().id;
        server.ended(&id).await;
        ids.push(id);
    }
    let mut filter = ListJobsRequest { page_size: 1, ..<_>::default() };
    filter.state = JobState::Succeeded.into();
    filter.labels.insert("cell".to_owned(), "1".to_owned());
    let first = client.list_jobs(filter.clone()).await.unwrap().into_inner();
    assert_eq!((first.jobs.len(), &first.jobs[0].id), (1, &ids[2]));
    filter.page_token = first.next_page_token.unwrap();
    let second = client.list_jobs(filter).await.unwrap().into_inner();
    assert_eq!((second.jobs.len(), &second.jobs[0].id), (1, &ids[0]));
    assert_eq!(second.next_page_token, None);
    let all = client.list_jobs(ListJobsRequest::default()).await.unwrap().into_inner();
    assert_eq!(all.jobs.len(), 3);
    let running = ListJobsRequest { state: JobState::Running.into(), ..<_>::default() };
    assert_eq!(client.list_jobs(running).await.unwrap().into_inner().jobs, []);
    let foreign = ListJobsRequest { page_token: "?".to_owned(), ..<_>::default() };
    let status = client.list_jobs(foreign).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::InvalidArgument, "invalid"));
}

/// Clients refuse messages over 4 MiB unless told otherwise; these are not.
#[tokio::test]
async fn a_large_result_comes_in_chunks_that_any_client_takes() {
    let server = Server::start().await;
    let id = server.create(LARGE).await.id;
    assert_eq!(server.ended(&id).await, JobState::Succeeded);
    let plain = server.planning().await;
    let gzip = server.planning().await.accept_compressed(CompressionEncoding::Gzip);
    for mut client in [plain, gzip] {
        let chunks = chunks(&mut client, whole(&id)).await.unwrap();
        let bytes: usize = chunks.iter().map(Message::encoded_len).sum();
        assert!(bytes > 4 << 20, "{bytes}");
        assert!(chunks.len() > 2);
        assert_eq!(join(chunks).unwrap(), result(LARGE));
    }
}

#[tokio::test]
async fn the_end_of_a_call_does_not_end_the_job() {
    let server = Server::start().await;
    let mut client = server.planning().await;
    let id = server.create(ENDLESS).await.id;
    let watch = WatchJobRequest { id: id.clone(), after_seq: 0 };
    let mut seen = client.watch_job(watch).await.unwrap().into_inner();
    while !matches!(seen.next().await.unwrap().unwrap().kind, Some(Kind::Progress(_))) {}
    drop((seen, client));

    let mut client = server.planning().await;
    let job = client.get_job(GetJobRequest { id: id.clone() }).await.unwrap().into_inner();
    assert_eq!(job.state(), JobState::Running);
    let status = chunks(&mut client, whole(&id)).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::FailedPrecondition, "not_ended"));

    client.cancel_job(CancelJobRequest { id: id.clone() }).await.unwrap();
    let last = events(&mut client, &id, 0).await.pop().unwrap();
    let Some(Kind::Finished(finished)) = last.kind else { panic!("{last:?}") };
    assert_eq!(finished.state(), JobState::Cancelled);
    let status = client.cancel_job(CancelJobRequest { id }).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::FailedPrecondition, "conflict"));
}

#[tokio::test]
async fn a_failed_job_tells_why_and_what_there_is_of_its_plan() {
    let server = Server::start().await;
    let mut client = server.planning().await;
    let id = server.create(FAILS).await.id;
    assert_eq!(server.ended(&id).await, JobState::Failed);
    let job = client.get_job(GetJobRequest { id: id.clone() }).await.unwrap().into_inner();
    let error = job.error.unwrap();
    assert_eq!((error.code.as_str(), error.message.as_str()), ("limits_unreachable", "no"));
    assert!(error.details.is_some());
    let status = chunks(&mut client, whole(&id)).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::FailedPrecondition, "no_result"));
    let partial = GetResultRequest { id, partial: true };
    let chunks = chunks(&mut client, partial).await.unwrap();
    assert_eq!(join(chunks).unwrap(), result(FAILS));
}

#[tokio::test]
async fn refusals_name_every_fault() {
    let server = Server::start().await;
    let mut client = server.planning().await;
    let mut request = job_request(SUCCEEDS);
    request.priority = Some(1000);
    request.plan.as_mut().unwrap().task = None;
    let status = client.create_job(request).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::InvalidArgument, "invalid"));
    let details = status.get_error_details();
    let violations = &details.bad_request().unwrap().field_violations;
    let fields: Vec<_> = violations.iter().map(|violation| violation.field.as_str()).collect();
    assert_eq!(fields, ["/task", "/priority"]);
    let metrics = server.service.metrics_text().unwrap();
    assert!(metrics.contains("takt_rejections_total{code=\"invalid\"} 1"), "{metrics}");

    let mut request = job_request(SUCCEEDS);
    let nobody = proto::robot_ref::Kind::Name("nobody".to_owned());
    request.plan.as_mut().unwrap().robot = Some(proto::RobotRef { kind: Some(nobody) });
    let status = client.create_job(request).await.unwrap_err();
    let details = status.get_error_details();
    assert_eq!(details.bad_request().unwrap().field_violations[0].field, "/robot");

    let unknown = "0197f8a0-0000-7000-8000-000000000000".to_owned();
    let status = client.get_job(GetJobRequest { id: unknown }).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::NotFound, "not_found"));
    let status = client.get_job(GetJobRequest { id: "x".to_owned() }).await.unwrap_err();
    let details = status.get_error_details();
    assert_eq!(details.bad_request().unwrap().field_violations[0].field, "/id");
}

#[tokio::test]
async fn an_idempotency_key_makes_a_repetition_harmless() {
    let server = Server::start().await;
    let mut client = server.planning().await;
    let keyed = |seed: u64| {
        let mut request = Request::new(job_request(seed));
        request.metadata_mut().insert("idempotency-key", "k1".parse().unwrap());
        request
    };
    let first = client.create_job(keyed(SUCCEEDS)).await.unwrap().into_inner();
    let again = client.create_job(keyed(SUCCEEDS)).await.unwrap().into_inner();
    assert_eq!(again.id, first.id);
    let status = client.create_job(keyed(FAILS)).await.unwrap_err();
    assert_eq!(status.code(), Code::AlreadyExists);
    assert_eq!(reason(&status), "idempotency_mismatch");
}

#[tokio::test]
async fn a_full_queue_says_when_to_come_again() {
    let server = Server::start().await;
    let mut client = server.planning().await;
    let mut refused = None;
    // One runs on each of the two workers, four wait.
    for _ in 0..7 {
        refused = client.create_job(job_request(ENDLESS)).await.err().or(refused);
    }
    let status = refused.unwrap();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::ResourceExhausted, "queue_full"));
    let delay = status.get_error_details().retry_info().unwrap().retry_delay;
    assert_eq!(delay, Some(Duration::from_secs(1)));
}

#[tokio::test]
async fn robots_are_registered_and_forgotten() {
    let server = Server::start().await;
    let mut client = RobotServiceClient::new(server.channel().await);
    let put = |robot| proto::PutRobotRequest { robot: Some(robot) };
    let get = |name: &str| proto::GetRobotRequest { name: name.to_owned() };
    let delete = |name: &str| proto::DeleteRobotRequest { name: name.to_owned() };
    let created = client.put_robot(put(robot("mine"))).await.unwrap().into_inner();
    assert!(created.created);
    assert!(!client.put_robot(put(robot("mine"))).await.unwrap().into_inner().created);
    let mine = client.get_robot(get("mine")).await.unwrap().into_inner();
    assert_eq!(Some(&mine), created.robot.as_ref());
    assert_eq!(mine.joints[3].limits.unwrap().jerk, None);

    let listed = client.list_robots(proto::ListRobotsRequest {}).await.unwrap().into_inner();
    let last = listed.robots.last().unwrap();
    assert_eq!((last.name.as_str(), last.dof), ("mine", 4));
    assert_eq!(last.origin(), proto::RobotOrigin::Registered);
    assert_eq!(listed.robots[0].origin(), proto::RobotOrigin::Catalogue);

    client.delete_robot(delete("mine")).await.unwrap();
    assert_eq!(client.get_robot(get("mine")).await.unwrap_err().code(), Code::NotFound);
    let built_in = &listed.robots[0].name;
    let status = client.delete_robot(delete(built_in)).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::FailedPrecondition, "conflict"));
    let status = client.put_robot(put(robot(""))).await.unwrap_err();
    let details = status.get_error_details();
    assert_eq!(details.bad_request().unwrap().field_violations[0].field, "/name");
}

#[tokio::test]
async fn unknown_methods_are_unimplemented_and_unknown_pages_not_found() {
    let server = Server::start().await;
    for path in ["/takt.v9.Nothing/Do", "/takt.v1.PlanningService/Do", "/nothing"] {
        let mut client = tonic::client::Grpc::new(server.channel().await);
        client.ready().await.unwrap();
        let codec = tonic_prost::ProstCodec::<(), ()>::default();
        let status = client.unary(Request::new(()), path.parse().unwrap(), codec).await;
        assert_eq!(status.unwrap_err().code(), Code::Unimplemented, "{path}");
    }
    let page = reqwest::get(format!("http://{}/nothing", server.address)).await.unwrap();
    assert_eq!(page.status(), 404);
    assert_eq!(page.headers()["content-type"], "application/problem+json");
}

#[tokio::test]
async fn health_follows_readiness() {
    let server = Server::start().await;
    let mut client = HealthClient::new(server.channel().await);
    let about = |service: &str| HealthCheckRequest { service: service.to_owned() };
    for service in ["", "takt.v1.PlanningService", "takt.v1.RobotService"] {
        let answer = client.check(about(service)).await.unwrap().into_inner();
        assert_eq!(answer.status(), ServingStatus::Serving, "{service}");
    }
    let status = client.check(about("takt.v9.Nothing")).await.unwrap_err();
    assert_eq!(status.code(), Code::NotFound);
    let mut watched = client.watch(about("")).await.unwrap().into_inner();
    assert_eq!(watched.next().await.unwrap().unwrap().status(), ServingStatus::Serving);

    server.service.drain(Duration::ZERO).await;
    let rest: Vec<_> = watched.map(|answer| answer.unwrap().status()).collect().await;
    assert_eq!(rest, [ServingStatus::NotServing]);
    let answer = client.check(about("")).await.unwrap().into_inner();
    assert_eq!(answer.status(), ServingStatus::NotServing);
    let status = server.planning().await.create_job(job_request(SUCCEEDS)).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::Unavailable, "draining"));
}

/// Asks for what generic clients ask for: services, then one's file.
macro_rules! reflect {
    ($server:expr, $version:ident) => {{
        use $version::server_reflection_request::MessageRequest;
        use $version::server_reflection_response::MessageResponse;
        let channel = $server.channel().await;
        let mut client = $version::server_reflection_client::ServerReflectionClient::new(channel);
        let ask = |message: MessageRequest| $version::ServerReflectionRequest {
            host: String::new(),
            message_request: Some(message),
        };
        let symbol = "takt.v1.PlanningService".to_owned();
        let questions = [
            ask(MessageRequest::ListServices(String::new())),
            ask(MessageRequest::FileContainingSymbol(symbol)),
        ];
        let answers =
            client.server_reflection_info(futures::stream::iter(questions)).await.unwrap();
        let answers: Vec<_> =
            answers.into_inner().map(|it| it.unwrap().message_response.unwrap()).collect().await;
        let MessageResponse::ListServicesResponse(list) = &answers[0] else { panic!("a list") };
        let MessageResponse::FileDescriptorResponse(file) = &answers[1] else { panic!("a file") };
        assert!(!file.file_descriptor_proto.is_empty());
        list.service.iter().map(|service| service.name.clone()).collect::<Vec<_>>()
    }};
}

#[tokio::test]
async fn reflection_lists_the_services() {
    let server = Server::start().await;
    for listed in [reflect!(server, v1), reflect!(server, v1alpha)] {
        for service in ["takt.v1.PlanningService", "takt.v1.RobotService", "grpc.health.v1.Health"]
        {
            assert!(listed.iter().any(|name| name == service), "{service} in {listed:?}");
        }
    }
}

/// A message as gRPC frames it: a flag byte, the length, the bytes.
fn framed(message: &impl Message) -> Vec<u8> {
    let bytes = message.encode_to_vec();
    let length = u32::try_from(bytes.len()).unwrap();
    [&[0], length.to_be_bytes().as_slice(), &bytes].concat()
}

#[tokio::test]
async fn a_browser_is_answered_in_grpc_web() {
    let server = Server::start().await;
    let ask = async |path: &str, message: Vec<u8>| {
        let request = reqwest::Client::new().post(format!("http://{}/{path}", server.address));
        let request = request.header("content-type", "application/grpc-web+proto").body(message);
        let response = request.header("x-request-id", "call-7").send().await.unwrap();
        assert_eq!(response.status(), 200);
        response
    };
    let list = framed(&proto::ListRobotsRequest {});
    let response = ask("takt.v1.RobotService/ListRobots", list).await;
    assert_eq!(response.headers()["content-type"], "application/grpc-web+proto");
    assert_eq!(response.headers()["x-request-id"], "call-7");
    let body = response.bytes().await.unwrap();
    let length = usize::try_from(u32::from_be_bytes(body[1..5].try_into().unwrap())).unwrap();
    let (message, trailers) = body[5..].split_at(length);
    let listed = proto::ListRobotsResponse::decode(message).unwrap();
    assert!(listed.robots.iter().any(|robot| robot.name == "rokae_xb4"));
    // The trailers come as a last frame, marked by the highest bit.
    assert_eq!(trailers[0], 0x80);
    assert!(String::from_utf8_lossy(trailers).contains("grpc-status:0"));

    let response = ask("takt.v9.Nothing/Do", framed(&())).await;
    assert_eq!(response.headers()["grpc-status"], "12");
    assert_eq!(response.headers()["content-type"], "application/grpc-web+proto");
}

#[tokio::test]
async fn messages_beyond_the_servers_limit_are_refused() {
    let server = Server::start().await;
    let mut request = job_request(SUCCEEDS);
    request.labels.insert("large".to_owned(), "x".repeat(2 << 20));
    let status = server.planning().await.create_job(request).await.unwrap_err();
    assert_eq!(status.code(), Code::OutOfRange);
}

/// The tests above put the edges together themselves; this one looks at the
/// server that users start.
#[tokio::test]
async fn the_whole_server_answers_calls_beside_rest() {
    let server = crate::support::Server::start().await;
    let post = |path: &str, content_type: &str| {
        let request = server.request(reqwest::Method::POST, path);
        request.header("content-type", content_type.to_owned()).body(framed(&())).send()
    };
    let health = post("/grpc.health.v1.Health/Check", "application/grpc-web+proto").await.unwrap();
    let body = health.bytes().await.unwrap();
    // A frame of two bytes: field 1, serving.
    assert_eq!(body[..7], [0, 0, 0, 0, 2, 8, 1]);
    let unknown = post("/takt.v9.Nothing/Do", "application/grpc").await.unwrap();
    assert_eq!(unknown.headers()["grpc-status"], "12");
    assert_eq!(server.get("/healthz").await.status(), 200);
}

/// Clients refuse messages beyond 4 MiB.
#[tokio::test]
async fn a_page_of_large_jobs_is_cut_before_clients_refuse_it() {
    const JOBS: usize = 40;
    let server = Server::start().await;
    let mut planning = server.planning().await;
    let labels = (0..64).map(|index| (format!("{index}"), "\u{1F916}".repeat(256)));
    let request = proto::JobRequest { labels: labels.collect(), ..job_request(SUCCEEDS) };
    for _ in 0..JOBS {
        let job = planning.create_job(request.clone()).await.unwrap().into_inner();
        server.ended(&job.id).await;
    }
    // The client that is used here has the usual limit.
    let mut filter = ListJobsRequest { page_size: 100, ..<_>::default() };
    let mut found = Vec::new();
    loop {
        let page = planning.list_jobs(filter.clone()).await.unwrap().into_inner();
        found.extend(page.jobs.into_iter().map(|job| job.id));
        let Some(token) = page.next_page_token else { break };
        filter.page_token = token;
    }
    found.sort();
    found.dedup();
    assert_eq!(found.len(), JOBS);
}
