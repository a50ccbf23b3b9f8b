; ModuleID = 'program.c'
source_filename = "program.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

@substitute.box = internal unnamed_addr constant [16 x i8] c"a$\\\C2\\\22xyz\\\\\00;}\00\00", align 16
@.str.1 = private unnamed_addr constant [4 x i8] c"%f\0A\00", align 1
@stderr = external local_unnamed_addr global ptr, align 8
@.str.2 = private unnamed_addr constant [7 x i8] c"%0.2f \00", align 1

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @atax(i32 noundef %0, i32 noundef %1, ptr nocapture noundef readonly %2, ptr nocapture noundef readonly %3, ptr nocapture noundef %4) local_unnamed_addr #0 {
  %6 = icmp sgt i32 %1, 0
  br i1 %6, label %7, label %10

7:                                                ; preds = %5
  %8 = zext i32 %1 to i64
  %9 = shl nuw nsw i64 %8, 2
  tail call void @llvm.memset.p0.i64(ptr align 4 %4, i8 0, i64 %9, i1 false), !tbaa !5
  br label %10

10:                                               ; preds = %7, %5
  %11 = icmp sgt i32 %0, 0
  br i1 %11, label %12, label %24

12:                                               ; preds = %10
  %13 = icmp sgt i32 %1, 0
  %14 = icmp sgt i32 %1, 0
  %15 = sext i32 %1 to i64
  %16 = sext i32 %1 to i64
  %17 = zext i32 %0 to i64
  %18 = zext i32 %1 to i64
  %19 = zext i32 %1 to i64
  br label %20

20:                                               ; preds = %12, %41
  %21 = phi i64 [ 0, %12 ], [ %42, %41 ]
  br i1 %13, label %22, label %25

22:                                               ; preds = %20
  %23 = mul nsw i64 %21, %15
  br label %29

24:                                               ; preds = %41, %10
  ret void

25:                                               ; preds = %29, %20
  %26 = phi float [ 0.000000e+00, %20 ], [ %38, %29 ]
  br i1 %14, label %27, label %41

27:                                               ; preds = %25
  %28 = mul nsw i64 %21, %16
  br label %44

29:                                               ; preds = %22, %29
  %30 = phi i64 [ 0, %22 ], [ %39, %29 ]
  %31 = phi float [ 0.000000e+00, %22 ], [ %38, %29 ]
  %32 = add nsw i64 %30, %23
  %33 = getelementptr inbounds float, ptr %2, i64 %32
  %34 = load float, ptr %33, align 4, !tbaa !5
  %35 = getelementptr inbounds float, ptr %3, i64 %30
  %36 = load float, ptr %35, align 4, !tbaa !5
  %37 = fmul float %34, %36
  %38 = fadd float %31, %37
  %39 = add nuw nsw i64 %30, 1
  %40 = icmp eq i64 %39, %18
  br i1 %40, label %25, label %29, !llvm.loop !9

41:                                               ; preds = %44, %25
  %42 = add nuw nsw i64 %21, 1
  %43 = icmp eq i64 %42, %17
  br i1 %43, label %24, label %20, !llvm.loop !12

44:                                               ; preds = %27, %44
  %45 = phi i64 [ 0, %27 ], [ %53, %44 ]
  %46 = add nsw i64 %45, %28
  %47 = getelementptr inbounds float, ptr %2, i64 %46
  %48 = load float, ptr %47, align 4, !tbaa !5
  %49 = fmul float %26, %48
  %50 = getelementptr inbounds float, ptr %4, i64 %45
  %51 = load float, ptr %50, align 4, !tbaa !5
  %52 = fadd float %51, %49
  store float %52, ptr %50, align 4, !tbaa !5
  %53 = add nuw nsw i64 %45, 1
  %54 = icmp eq i64 %53, %19
  br i1 %54, label %41, label %44, !llvm.loop !13
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @levinson(i32 noundef %0, ptr nocapture noundef readonly %1, ptr nocapture noundef %2, ptr nocapture noundef %3) local_unnamed_addr #0 {
  %5 = load float, ptr %1, align 4, !tbaa !5
  %6 = fneg float %5
  store float %6, ptr %2, align 4, !tbaa !5
  %7 = icmp sgt i32 %0, 1
  br i1 %7, label %8, label %10

8:                                                ; preds = %4
  %9 = zext i32 %0 to i64
  br label %11

10:                                               ; preds = %49, %4
  ret void

11:                                               ; preds = %8, %49
  %12 = phi i64 [ 1, %8 ], [ %51, %49 ]
  %13 = phi float [ %6, %8 ], [ %22, %49 ]
  %14 = phi float [ 1.000000e+00, %8 ], [ %20, %49 ]
  %15 = getelementptr inbounds float, ptr %1, i64 %12
  %16 = load float, ptr %15, align 4, !tbaa !5
  %17 = fmul float %13, %13
  %18 = fsub float 1.000000e+00, %17
  br label %23

19:                                               ; preds = %23
  %20 = fmul float %14, %18
  %21 = fneg float %33
  %22 = fdiv float %21, %20
  br label %36

23:                                               ; preds = %11, %23
  %24 = phi i64 [ 0, %11 ], [ %34, %23 ]
  %25 = phi float [ %16, %11 ], [ %33, %23 ]
  %26 = xor i64 %24, -1
  %27 = add nsw i64 %12, %26
  %28 = getelementptr inbounds float, ptr %1, i64 %27
  %29 = load float, ptr %28, align 4, !tbaa !5
  %30 = getelementptr inbounds float, ptr %2, i64 %24
  %31 = load float, ptr %30, align 4, !tbaa !5
  %32 = fmul float %29, %31
  %33 = fadd float %25, %32
  %34 = add nuw nsw i64 %24, 1
  %35 = icmp eq i64 %34, %12
  br i1 %35, label %19, label %23, !llvm.loop !14

36:                                               ; preds = %19, %36
  %37 = phi i64 [ 0, %19 ], [ %47, %36 ]
  %38 = getelementptr inbounds float, ptr %2, i64 %37
  %39 = load float, ptr %38, align 4, !tbaa !5
  %40 = xor i64 %37, -1
  %41 = add nsw i64 %12, %40
  %42 = getelementptr inbounds float, ptr %2, i64 %41
  %43 = load float, ptr %42, align 4, !tbaa !5
  %44 = fmul float %22, %43
  %45 = fadd float %39, %44
  %46 = getelementptr inbounds float, ptr %3, i64 %37
  store float %45, ptr %46, align 4, !tbaa !5
  %47 = add nuw nsw i64 %37, 1
  %48 = icmp eq i64 %47, %12
  br i1 %48, label %53, label %36, !llvm.loop !15

49:                                               ; preds = %53
  %50 = getelementptr inbounds float, ptr %2, i64 %12
  store float %22, ptr %50, align 4, !tbaa !5
  %51 = add nuw nsw i64 %12, 1
  %52 = icmp eq i64 %51, %9
  br i1 %52, label %10, label %11, !llvm.loop !16

53:                                               ; preds = %36, %53
  %54 = phi i64 [ %58, %53 ], [ 0, %36 ]
  %55 = getelementptr inbounds float, ptr %3, i64 %54
  %56 = load float, ptr %55, align 4, !tbaa !5
  %57 = getelementptr inbounds float, ptr %2, i64 %54
  store float %56, ptr %57, align 4, !tbaa !5
  %58 = add nuw nsw i64 %54, 1
  %59 = icmp eq i64 %58, %12
  br i1 %59, label %49, label %53, !llvm.loop !17
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @substitute(ptr nocapture noundef readonly %0, ptr nocapture noundef writeonly %1, i32 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i32 %2, 0
  br i1 %4, label %5, label %7

5:                                                ; preds = %3
  %6 = zext i32 %2 to i64
  br label %8

7:                                                ; preds = %8, %3
  ret void

8:                                                ; preds = %5, %8
  %9 = phi i64 [ 0, %5 ], [ %17, %8 ]
  %10 = getelementptr inbounds i8, ptr %0, i64 %9
  %11 = load i8, ptr %10, align 1, !tbaa !18
  %12 = and i8 %11, 15
  %13 = zext i8 %12 to i64
  %14 = getelementptr inbounds [16 x i8], ptr @substitute.box, i64 0, i64 %13
  %15 = load i8, ptr %14, align 1, !tbaa !18
  %16 = getelementptr inbounds i8, ptr %1, i64 %9
  store i8 %15, ptr %16, align 1, !tbaa !18
  %17 = add nuw nsw i64 %9, 1
  %18 = icmp eq i64 %17, %6
  br i1 %18, label %7, label %8, !llvm.loop !19
}

; Function Attrs: nounwind uwtable
define dso_local i32 @main(i32 noundef %0, ptr nocapture noundef readonly %1) local_unnamed_addr #1 {
  %3 = tail call noalias dereferenceable_or_null(6400) ptr @malloc(i64 noundef 6400) #7
  %4 = tail call noalias dereferenceable_or_null(160) ptr @malloc(i64 noundef 160) #7
  %5 = tail call noalias dereferenceable_or_null(160) ptr @malloc(i64 noundef 160) #7
  tail call void @prepare() #8
  tail call void @llvm.memset.p0.i64(ptr noundef nonnull align 4 dereferenceable(160) %5, i8 0, i64 160, i1 false), !tbaa !5
  br label %6

6:                                                ; preds = %21, %2
  %7 = phi i64 [ 0, %2 ], [ %22, %21 ]
  %8 = mul nuw nsw i64 %7, 40
  br label %9

9:                                                ; preds = %9, %6
  %10 = phi i64 [ 0, %6 ], [ %19, %9 ]
  %11 = phi float [ 0.000000e+00, %6 ], [ %18, %9 ]
  %12 = add nuw nsw i64 %10, %8
  %13 = getelementptr inbounds float, ptr %3, i64 %12
  %14 = load float, ptr %13, align 4, !tbaa !5
  %15 = getelementptr inbounds float, ptr %4, i64 %10
  %16 = load float, ptr %15, align 4, !tbaa !5
  %17 = fmul float %14, %16
  %18 = fadd float %11, %17
  %19 = add nuw nsw i64 %10, 1
  %20 = icmp eq i64 %19, 40
  br i1 %20, label %24, label %9, !llvm.loop !9

21:                                               ; preds = %24
  %22 = add nuw nsw i64 %7, 1
  %23 = icmp eq i64 %22, 40
  br i1 %23, label %35, label %6, !llvm.loop !12

24:                                               ; preds = %9, %24
  %25 = phi i64 [ %33, %24 ], [ 0, %9 ]
  %26 = add nuw nsw i64 %25, %8
  %27 = getelementptr inbounds float, ptr %3, i64 %26
  %28 = load float, ptr %27, align 4, !tbaa !5
  %29 = fmul float %18, %28
  %30 = getelementptr inbounds float, ptr %5, i64 %25
  %31 = load float, ptr %30, align 4, !tbaa !5
  %32 = fadd float %31, %29
  store float %32, ptr %30, align 4, !tbaa !5
  %33 = add nuw nsw i64 %25, 1
  %34 = icmp eq i64 %33, 40
  br i1 %34, label %21, label %24, !llvm.loop !13

35:                                               ; preds = %21
  %36 = icmp sgt i32 %0, 42
  br i1 %36, label %37, label %50

37:                                               ; preds = %35
  %38 = load ptr, ptr %1, align 8, !tbaa !20
  %39 = load i8, ptr %38, align 1
  %40 = icmp eq i8 %39, 0
  br i1 %40, label %41, label %50

41:                                               ; preds = %37, %41
  %42 = phi i64 [ %48, %41 ], [ 0, %37 ]
  %43 = load ptr, ptr @stderr, align 8, !tbaa !20
  %44 = getelementptr inbounds float, ptr %5, i64 %42
  %45 = load float, ptr %44, align 4, !tbaa !5
  %46 = fpext float %45 to double
  %47 = tail call i32 (ptr, ptr, ...) @fprintf(ptr noundef %43, ptr noundef nonnull @.str.2, double noundef %46) #9
  %48 = add nuw nsw i64 %42, 1
  %49 = icmp eq i64 %48, 40
  br i1 %49, label %50, label %41, !llvm.loop !22

50:                                               ; preds = %41, %37, %35
  %51 = tail call double @seconds() #8
  %52 = tail call i32 (ptr, ...) @printf(ptr noundef nonnull dereferenceable(1) @.str.1, double noundef %51)
  tail call void @free(ptr noundef %5) #8
  ret i32 0
}

; Function Attrs: mustprogress nofree nounwind willreturn allockind("alloc,uninitialized") allocsize(0) memory(inaccessiblemem: readwrite)
declare noalias noundef ptr @malloc(i64 noundef) local_unnamed_addr #2

declare void @prepare() local_unnamed_addr #3

; Function Attrs: nofree nounwind
declare noundef i32 @printf(ptr nocapture noundef readonly, ...) local_unnamed_addr #4

declare double @seconds() local_unnamed_addr #3

; Function Attrs: mustprogress nounwind willreturn allockind("free") memory(argmem: readwrite, inaccessiblemem: readwrite)
declare void @free(ptr allocptr nocapture noundef) local_unnamed_addr #5

; Function Attrs: nofree nounwind
declare noundef i32 @fprintf(ptr nocapture noundef, ptr nocapture noundef readonly, ...) local_unnamed_addr #4

; Function Attrs: nocallback nofree nounwind willreturn memory(argmem: write)
declare void @llvm.memset.p0.i64(ptr nocapture writeonly, i8, i64, i1 immarg) #6

attributes #0 = { nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { nounwind uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #2 = { mustprogress nofree nounwind willreturn allockind("alloc,uninitialized") allocsize(0) memory(inaccessiblemem: readwrite) "alloc-family"="malloc" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #3 = { "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #4 = { nofree nounwind "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #5 = { mustprogress nounwind willreturn allockind("free") memory(argmem: readwrite, inaccessiblemem: readwrite) "alloc-family"="malloc" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #6 = { nocallback nofree nounwind willreturn memory(argmem: write) }
attributes #7 = { nounwind allocsize(0) }
attributes #8 = { nounwind }
attributes #9 = { cold }

!llvm.module.flags = !{!0, !1, !2, !3}
!llvm.ident = !{!4}

!0 = !{i32 1, !"wchar_size", i32 4}
!1 = !{i32 8, !"PIC Level", i32 2}
!2 = !{i32 7, !"PIE Level", i32 2}
!3 = !{i32 7, !"uwtable", i32 2}
!4 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!5 = !{!6, !6, i64 0}
!6 = !{!"float", !7, i64 0}
!7 = !{!"omnipotent char", !8, i64 0}
!8 = !{!"Simple C/C++ TBAA"}
!9 = distinct !{!9, !10, !11}
!10 = !{!"llvm.loop.mustprogress"}
!11 = !{!"llvm.loop.unroll.disable"}
!12 = distinct !{!12, !10, !11}
!13 = distinct !{!13, !10, !11}
!14 = distinct !{!14, !10, !11}
!15 = distinct !{!15, !10, !11}
!16 = distinct !{!16, !10, !11}
!17 = distinct !{!17, !10, !11}
!18 = !{!7, !7, i64 0}
!19 = distinct !{!19, !10, !11}
!20 = !{!21, !21, i64 0}
!21 = !{!"any pointer", !7, i64 0}
!22 = distinct !{!22, !10, !11}
