//! Submission of commands; each is timed and waited for.

use super::{Commands, Gpu, GpuError, Named, ending};
use ash::vk;
use hypertexture_support::faults;
use hypertexture_support::watchdog::Watchdog;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Timeout of a submission. Lower: slow devices fail on large images. Higher: a hang goes unnoticed; desktops reset the
/// device after two seconds anyway.
const TIMEOUT_SECONDS: u64 = 60;

/// Interval at which a wait looks for the end of the program.
const SLICE: Duration = Duration::from_millis(100);

/// Cost of a submission.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Submitted {
    /// Milliseconds on the device by timestamps, or by the wall clock if it has none.
    pub gpu_ms: f64,
    /// Milliseconds from submission to completion.
    pub wall_ms: f64,
    /// Fragment shader invocations, if the device counts them.
    pub fragments: Option<u64>,
}

impl Gpu {
    /// Records commands, submits them and waits until they are done.
    ///
    /// # Errors
    /// A call fails, or the device does not finish within a minute.
    pub fn submit(&self, what: &str, record: impl FnOnce(&mut Commands<'_>)) -> Result<Submitted, GpuError> {
        let device = &self.0.device;
        // The lock makes this thread the only user of pool and queue.
        let queue = self.queue();
        let job = Job::new(self)?;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is new and unused.
        unsafe { device.begin_command_buffer(job.buffer, &begin) }.named("vkBeginCommandBuffer")?;
        let mut commands = Commands { gpu: self, buffer: job.buffer };
        let timed = self.0.info.timestamp_period > 0.0;
        // SAFETY: the command buffer is being recorded; the pool has two queries.
        unsafe {
            if timed {
                device.cmd_reset_query_pool(job.buffer, job.queries, 0, 2);
                device.cmd_write_timestamp2(job.buffer, vk::PipelineStageFlags2::ALL_COMMANDS, job.queries, 0);
            }
            if job.statistics != vk::QueryPool::null() {
                device.cmd_reset_query_pool(job.buffer, job.statistics, 0, 1);
                device.cmd_begin_query(job.buffer, job.statistics, 0, vk::QueryControlFlags::empty());
            }
            record(&mut commands);
            if job.statistics != vk::QueryPool::null() {
                device.cmd_end_query(job.buffer, job.statistics, 0);
            }
            if timed {
                device.cmd_write_timestamp2(job.buffer, vk::PipelineStageFlags2::ALL_COMMANDS, job.queries, 1);
            }
            device.end_command_buffer(job.buffer).named("vkEndCommandBuffer")?;
        }
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(job.buffer)];
        let start = Instant::now();
        // SAFETY: the queue is locked; the caller borrows the resources of the commands for longer than this call, and the
        // job lives until the fence is signaled. After a timeout nothing is freed any more.
        unsafe {
            let submits = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
            device.queue_submit2(*queue, &submits, job.fence).named("vkQueueSubmit2")?;
            let waited = self.wait_for(job.fence, what);
            if waited.as_ref().is_err_and(|error| !error.is_lost() || error.is_timeout()) {
                self.give_up();
            }
            waited?;
        }
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        let mut fragments = None;
        if job.statistics != vk::QueryPool::null() {
            let mut count = [0u64];
            // SAFETY: the query was ended by the finished submission.
            unsafe { device.get_query_pool_results(job.statistics, 0, &mut count, flags) }
                .named("vkGetQueryPoolResults")?;
            fragments = Some(count[0]);
        }
        if !timed {
            return Ok(Submitted { gpu_ms: wall_ms, wall_ms, fragments });
        }
        let mut ticks = [0u64; 2];
        // SAFETY: both queries were written by the finished submission.
        unsafe { device.get_query_pool_results(job.queries, 0, &mut ticks, flags) }.named("vkGetQueryPoolResults")?;
        let gpu_ms = self.0.info.milliseconds(ticks);
        Ok(Submitted { gpu_ms, wall_ms, fragments })
    }

    /// Waits for a fence for a minute. After it, a driver on the CPU has until it has used another one of processor time,
    /// or none for three: a loaded machine is slow without a hang. After a signal that ends the program, the wait is short.
    pub(super) fn wait_for(&self, fence: vk::Fence, what: &str) -> Result<(), GpuError> {
        self.0.waits.fetch_add(1, Ordering::Relaxed);
        let (limit, start) = (Duration::from_secs(TIMEOUT_SECONDS), Instant::now());
        let (mut watch, patience) = (None, if faults::are_on() { limit } else { SLICE });
        loop {
            let is_awaited = || self.info().cpu && start.elapsed() >= limit;
            // SAFETY: the fence belongs to the device.
            match unsafe { self.0.device.wait_for_fences(&[fence], true, patience.as_nanos() as u64) } {
                Err(vk::Result::TIMEOUT) if ending::gives_up(start) => {
                    ending::leave_device();
                    return Err(GpuError::Interrupted { what: what.into() });
                }
                Err(vk::Result::TIMEOUT) if patience < limit && start.elapsed() < limit => {}
                Err(vk::Result::TIMEOUT)
                    if is_awaited()
                        && watch
                            .get_or_insert_with(|| Watchdog::new(std::process::id(), limit, u64::MAX))
                            .excess()
                            .is_none() => {}
                Err(vk::Result::TIMEOUT) => {
                    return Err(GpuError::Timeout { what: what.into(), seconds: TIMEOUT_SECONDS });
                }
                other => return other.named("vkWaitForFences"),
            }
        }
    }
}

/// Handles of one submission, freed at its end.
struct Job<'a> {
    gpu: &'a Gpu,
    buffer: vk::CommandBuffer,
    fence: vk::Fence,
    queries: vk::QueryPool,
    statistics: vk::QueryPool,
}

impl<'a> Job<'a> {
    fn new(gpu: &'a Gpu) -> Result<Job<'a>, GpuError> {
        let device = &gpu.0.device;
        let (fence, queries) = (vk::Fence::null(), vk::QueryPool::null());
        let info = vk::CommandBufferAllocateInfo::default().command_pool(gpu.0.pool.handle).command_buffer_count(1);
        // SAFETY: the pool belongs to the device and is only used under the queue's lock.
        let buffer = unsafe { device.allocate_command_buffers(&info) }.named("vkAllocateCommandBuffers")?[0];
        let mut job = Job { gpu, buffer, fence, queries, statistics: queries };
        // SAFETY: the device is alive; each handle is owned as soon as it exists.
        unsafe {
            job.fence = device.create_fence(&vk::FenceCreateInfo::default(), None).named("vkCreateFence")?;
            let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2);
            job.queries = device.create_query_pool(&info, None).named("vkCreateQueryPool")?;
            if gpu.info().counts_fragments {
                let info = vk::QueryPoolCreateInfo::default()
                    .query_type(vk::QueryType::PIPELINE_STATISTICS)
                    .pipeline_statistics(vk::QueryPipelineStatisticFlags::FRAGMENT_SHADER_INVOCATIONS)
                    .query_count(1);
                job.statistics = device.create_query_pool(&info, None).named("vkCreateQueryPool")?;
            }
        }
        Ok(job)
    }
}

impl Drop for Job<'_> {
    fn drop(&mut self) {
        // SAFETY: the handles are unused: the fence was signaled, or the device is lost.
        self.gpu.free(|device| unsafe {
            device.free_command_buffers(self.gpu.0.pool.handle, &[self.buffer]);
            device.destroy_fence(self.fence, None);
            device.destroy_query_pool(self.queries, None);
            device.destroy_query_pool(self.statistics, None);
        });
    }
}
